// How many of the tiles of each block go on.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 2) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 4) readonly buffer TileRepetitions { uint tile_repetitions[]; };
layout(std430, binding = 5) writeonly buffer TileSums { uint block_sums[]; };
layout(push_constant) uniform AdaptConstants { uint done; } stage;  // repetitions of earlier stages
#include "going_on.glsl"
#define SCAN_TYPE uint
#include "common/scan.glsl"

void main() {
    uint all = scan_workgroup(goes_on(gl_GlobalInvocationID.x) ? 1u : 0u).all;
    if (gl_LocalInvocationID.x == 0u) {
        block_sums[gl_WorkGroupID.x] = all;
    }
}
