// How many pairs of each block are needed.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "items.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 2) writeonly buffer ItemSums { uvec2 block_sums[]; };
#define SCAN_TYPE uvec2
#include "common/scan.glsl"

void main() {
    uvec2 all = scan_workgroup(needs_of(gl_GlobalInvocationID.x)).all;
    if (gl_LocalInvocationID.x == 0u) {
        block_sums[gl_WorkGroupID.x] = all;
    }
}
