// The table of ln(1 - G): G is the probability that a render particle of a physical particle passes at a place, nearer than a depth.
// Classes of the threshold; places across the ray's offset from the particle's centre; depths through the space of its render particles.
const int CLASSES = 32;  // bits of a word
const int PLACES = 97;
const int DEPTHS = 16;
const uint SHARE_SIDE = 32u;  // texels of the pass shares along a side; the mask's own where its level has fewer

// How far sprites reach across, in metres.
float kernel_reach() {
    return params.bounding_radius + 0.5 * params.sprite_size;
}

// Classes are evenly spaced in alpha, 1 / threshold: as temperatures are. The first is where nothing passes any more, the last
// that of the settings' hottest temperature.
vec2 class_alphas() {
    float lowest = 1.0 / max(params.max_alpha, 1e-6);
    // At a threshold of 0 all of the mask passes, whatever the alpha.
    float highest = params.threshold > 0.0 ? min(params.alpha_scale / params.threshold, 1e6) : 1e6;
    return vec2(lowest, max(highest, lowest));
}

// The threshold of a class, as alpha of the mask.
float class_threshold(uint index) {
    vec2 range = class_alphas();
    return 1.0 / mix(range.x, range.y, float(index) / float(CLASSES - 1));
}

// Whether a class is in a set of them.
bool has_class(uint set, uint index) {
    return (set >> index & 1u) != 0u;
}

// The place of a threshold among the classes; a particle's own is never the first.
float class_place(float threshold) {
    vec2 range = class_alphas();
    float share = (1.0 / max(threshold, 1e-30) - range.x) / max(range.y - range.x, 1e-6);
    return clamp(share * float(CLASSES - 1), 1.0, float(CLASSES - 1));
}

// Whether what a particle's sprites can reach is so narrow that pixels' centres would miss the table's middle. `pixel`: its side at
// the particle's depth, in metres.
bool is_narrow(float pixel) {
    return kernel_reach() < 0.75 * pixel;
}
