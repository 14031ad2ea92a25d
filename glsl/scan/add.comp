// The second half of a prefix sum: each word becomes the sum of all before it.
#version 460
#include "block.glsl"
layout(std430, binding = 0) buffer Values { uvec4 values[]; };
layout(std430, binding = 1) readonly buffer BlockSums { uint block_sums[]; };
#define SCAN_TYPE uint
#define SCAN_BLOCKS
#include "common/scan.glsl"

void main() {
    uint at = gl_GlobalInvocationID.x;
    uvec4 own = at < constants.vectors ? values[at] : uvec4(0u);
    uint before = scan_blocks(gl_WorkGroupID.x, gl_WorkGroupID.x).all;
    before += scan_workgroup(own.x + own.y + own.z + own.w).before;
    uvec4 sums = before + uvec4(0u, own.x, own.x + own.y, own.x + own.y + own.z);
    if (at < constants.vectors) {
        values[at] = sums;
    }
}
