// The second half of a prefix sum: each word becomes the sum of all before it.
#version 460
#extension GL_EXT_control_flow_attributes : require
#include "block.glsl"
layout(std430, binding = 0) buffer Values { uvec4 values[]; };
layout(std430, binding = 1) readonly buffer BlockSums { uint block_sums[]; };
#define SCAN_TYPE uint
#define SCAN_BLOCKS
#include "common/scan.glsl"

void main() {
    uint first = SCAN_VECTORS * gl_GlobalInvocationID.x;
    uvec4 own[SCAN_VECTORS];
    uint sum = 0u;
    [[unroll]] for (uint i = 0u; i < SCAN_VECTORS; ++i) {
        own[i] = first + i < constants.vectors ? values[first + i] : uvec4(0u);
        sum += sum_of(own[i]);
    }
    uint before = scan_blocks(gl_WorkGroupID.x, gl_WorkGroupID.x).all;
    before += scan_workgroup(sum).before;
    [[unroll]] for (uint i = 0u; i < SCAN_VECTORS; ++i) {
        if (first + i < constants.vectors) {
            values[first + i] = before + uvec4(0u, own[i].x, own[i].x + own[i].y, own[i].x + own[i].y + own[i].z);
        }
        before += sum_of(own[i]);
    }
}
