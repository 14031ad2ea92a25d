// A level of the mask: the alphas below each of its texels in descending order, which is the inverse of the texel's pass
// probability as a function of the threshold. Nothing is averaged: at any threshold, the share of the values that pass is the share of the texel
// that passes. Four sorted runs of the level before are merged: a value's place is its own plus how many of the other runs come before it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(binding = 1, r32f) uniform image2D levels;
layout(push_constant) uniform MipsConstants { uint level; } constants;
#include "mask_place.glsl"

// What a texel of the mask contributes: the mask within it, between texels as look-ups are, away from its centre by a pattern of 2 x 2, so
// that shares of values are shares of area.
float mask_sample(uvec2 texel, uint variant) {
    vec2 odd = vec2(texel & 1u);
    vec2 at = vec2(texel) + 0.25 * vec2(2.0 * odd.x + odd.y, 2.0 * odd.y + 1.0 - odd.x) - 0.375;
    vec2 u = (at + 0.5) * (2.0 / float(MASK_SIDE)) - 1.0;
    at = clamp(at, 0.0, float(MASK_SIDE - 1u));
    ivec2 low = min(ivec2(at), ivec2(MASK_SIDE - 2u));
    vec2 f = at - vec2(low);
    low.y += int(variant * MASK_SIDE);
    precise float upper = mix(imageLoad(levels, low).r, imageLoad(levels, low + ivec2(1, 0)).r, f.x);
    precise float lower = mix(imageLoad(levels, low + ivec2(0, 1)).r, imageLoad(levels, low + ivec2(1, 1)).r, f.x);
    precise float value = mix(upper, lower, f.y);
    return dot(u, u) < 1.0 ? value : 0.0;
}

float value_below(uint level, uvec2 texel, uint variant, uint index) {
    return level == 0u ? mask_sample(texel, variant) : imageLoad(levels, mask_place(level, texel, variant, index)).r;
}

void main() {
    uint thread = gl_GlobalInvocationID.x;
    uint variant = thread / (MASK_SIDE * MASK_SIDE);
    if (variant >= params.variants) {
        return;
    }
    uint below_level = constants.level - 1u;
    uint run_length = 1u << (2u * below_level);
    uvec2 base = uvec2(thread % MASK_SIDE, thread / MASK_SIDE % MASK_SIDE);
    uvec2 from = base >> below_level;
    uint side = (1u << below_level) - 1u;
    uint own = (base.y & side) << below_level | (base.x & side);
    float value = value_below(below_level, from, variant, own);
    uvec2 texel = from >> 1u;
    uint own_run = (from.y & 1u) << 1u | (from.x & 1u);
    uint rank = own;
    for (uint run = 0u; run < 4u; ++run) {
        if (run != own_run) {
            uvec2 other = texel * 2u + uvec2(run & 1u, run >> 1u);
            // How many of the run come before: larger ones, and equal ones of runs before this.
            uint low = 0u;
            uint high = run_length;
            while (low < high) {
                uint middle = (low + high) / 2u;
                float there = value_below(below_level, other, variant, middle);
                bool before = there > value || (there == value && run < own_run);
                low = before ? middle + 1u : low;
                high = before ? high : middle;
            }
            rank += low;
        }
    }
    imageStore(levels, mask_place(constants.level, texel, variant, rank), vec4(value));
}
