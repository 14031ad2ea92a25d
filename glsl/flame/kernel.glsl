// The table of ln(1 - G): G is the probability that a render particle of a physical particle passes at a place, nearer than a depth.
// Classes of the threshold; places across the ray's offset from the particle's centre; depths through the space of its render particles.
const uint KERNEL_CLASSES = 32u;  // bits of a word
const uint KERNEL_PLACES = 97u;   // along x and along y
const uint KERNEL_DEPTHS = 16u;
const uint SHARE_SIDE = 32u;      // texels of the pass shares along a side; the mask's own where its level has fewer
const uint MASK_PLACES = 16u;     // places of the mask along a side that are looked at, at least;
const uint FINE_MASK_PLACES = 32u;  // where the space is as narrow as two of them
const float LEAST_LOGARITHM = -24.0;
const float NARROW = 0.75;        // of a pixel: sprites that reach less far are narrow
const uint KERNEL_LANES = 64u;    // of the workgroups that make the table
const float LAST_PLACE = float(KERNEL_PLACES - 1u);
const float OPAQUE = 1e-6;        // transmittance below which nothing is seen any more

// ln(1 - p): the series where 1 - p would lose p's digits.
float logarithm_of_rest(float p) {
    return p < 0.01 ? -p * (1.0 + p * (0.5 + p * (0.33333333 + p * 0.25))) : log(max(1.0 - p, 1e-30));
}

float ball_volume(float radius) {
    return 4.18879020478639 * radius * radius * radius;
}

// Where the table has a place, depth and class.
ivec2 kernel_texel(ivec2 place, int depth, int class_index) {
    return ivec2(int(KERNEL_DEPTHS) * place.x + depth, place.y + int(KERNEL_PLACES) * class_index);
}

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
    return 1.0 / mix(range.x, range.y, float(index) / float(KERNEL_CLASSES - 1u));
}

// Whether a class is in a set of them.
bool has_class(uint set, uint index) {
    return (set >> index & 1u) != 0u;
}

// The place of a threshold among the classes; a particle's own is never the first.
float class_place(float threshold) {
    vec2 range = class_alphas();
    float share = (1.0 / max(threshold, 1e-30) - range.x) / max(range.y - range.x, 1e-6);
    return clamp(share * float(KERNEL_CLASSES - 1u), 1.0, float(KERNEL_CLASSES - 1u));
}

// Whether what a particle's sprites can reach is so narrow that pixels' centres would miss the table's middle. `pixel`: its side at
// the particle's depth, in metres.
bool is_narrow(float pixel) {
    return kernel_reach() < NARROW * pixel;
}
