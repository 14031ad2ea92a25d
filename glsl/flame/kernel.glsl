// The table of ln(1 - G): G is the probability that a render particle of a physical particle passes at a place, nearer than a depth.
// Classes of the threshold; places across the ray's offset from the particle's centre; depths through the space of its render particles.
const int CLASSES = 48;
const int PLACES = 49;
const int DEPTHS = 25;
const uint SHARE_SIDE = 32u;  // texels of the pass shares along a side; the mask's own where its level has fewer

// How far sprites reach across, in metres.
float kernel_reach() {
    return params.space.z + 0.5 * params.space.y;
}

// The threshold of a class, as alpha of the mask.
float class_threshold(uint index) {
    return params.light.y * float(index) / float(CLASSES - 1);
}
