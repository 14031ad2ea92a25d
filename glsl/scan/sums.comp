// The first half of a prefix sum: the sum of each block.
#version 460
#include "block.glsl"
layout(std430, binding = 0) readonly buffer Values { uvec4 values[]; };
layout(std430, binding = 1) writeonly buffer BlockSums { uint block_sums[]; };
#define SCAN_TYPE uint
#include "common/scan.glsl"

void main() {
    uint at = gl_GlobalInvocationID.x;
    uvec4 own = at < constants.vectors ? values[at] : uvec4(0u);
    uint all = scan_workgroup(own.x + own.y + own.z + own.w).all;
    if (gl_LocalInvocationID.x == 0u) {
        block_sums[gl_WorkGroupID.x] = all;
    }
}
