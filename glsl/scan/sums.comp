// The first half of a prefix sum: the sum of each block.
#version 460
#extension GL_EXT_control_flow_attributes : require
#include "block.glsl"
layout(std430, binding = 0) readonly buffer Values { uvec4 values[]; };
layout(std430, binding = 1) writeonly buffer BlockSums { uint block_sums[]; };
#define SCAN_TYPE uint
#include "common/scan.glsl"

void main() {
    uint first = SCAN_VECTORS * gl_GlobalInvocationID.x;
    uint own = 0u;
    [[unroll]] for (uint i = 0u; i < SCAN_VECTORS; ++i) {
        own += first + i < constants.vectors ? sum_of(values[first + i]) : 0u;
    }
    uint all = scan_workgroup(own).all;
    if (gl_LocalInvocationID.x == 0u) {
        block_sums[gl_WorkGroupID.x] = all;
    }
}
