#include "mask_place.glsl"

// How many of the alphas below a texel pass: they are in descending order. An alpha of 0 never passes.
uint pass_count(uint level, uvec2 texel, uint variant, float threshold) {
    uint low = 0u;
    uint high = 1u << (2u * level);
    while (low < high) {
        uint middle = (low + high) / 2u;
        float alpha = imageLoad(levels, mask_place(level, texel, variant, middle)).r;
        bool passes = alpha > 0.0 && alpha >= threshold;
        low = passes ? middle + 1u : low;
        high = passes ? high : middle;
    }
    return low;
}
