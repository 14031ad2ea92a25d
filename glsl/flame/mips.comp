// A level of the mask: the alphas below each of its texels in descending order, which is the inverse of the texel's pass
// probability as a function of the threshold. Nothing is averaged: at any threshold, the share of the values that pass is the share of the texel
// that passes. Four sorted runs of the level before are merged: a value's place is its own plus how many of the other runs come before it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(binding = 1, r32f) uniform image2D levels;
layout(push_constant) uniform MipsConstants { uint level; } constants;

ivec2 place(uint level, uvec2 texel, uint variant, uint index) {
    uint side = (1u << level) - 1u;
    return ivec2(level * MASK_SIDE + (texel.x << level) + (index & side), variant * MASK_SIDE + (texel.y << level) + (index >> level));
}

void main() {
    uint thread = gl_GlobalInvocationID.x;
    uint variant = thread / (MASK_SIDE * MASK_SIDE);
    if (variant >= params.draw.y) {
        return;
    }
    uint below_level = constants.level - 1u;
    uint run_length = 1u << (2u * below_level);
    uvec2 base = uvec2(thread % MASK_SIDE, thread / MASK_SIDE % MASK_SIDE);
    uvec2 from = base >> below_level;
    uint side = (1u << below_level) - 1u;
    uint own = (base.y & side) << below_level | (base.x & side);
    float value = imageLoad(levels, place(below_level, from, variant, own)).r;
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
                float there = imageLoad(levels, place(below_level, other, variant, middle)).r;
                bool before = there > value || (there == value && run < own_run);
                low = before ? middle + 1u : low;
                high = before ? high : middle;
            }
            rank += low;
        }
    }
    imageStore(levels, place(constants.level, texel, variant, rank), vec4(value));
}
