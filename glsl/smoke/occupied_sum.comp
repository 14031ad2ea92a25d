// How many tiles of each block show anything; and, where light-space lists are worked on in parts, how long the longest of each level is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "occupied.glsl"
#include "cells.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 2) readonly buffer Cells { uint cell_ends[]; };
layout(std430, binding = 3) buffer ControlBuffer { Control control; };
layout(std430, binding = 4) writeonly buffer TileSums { uint block_sums[]; };
layout(push_constant) uniform OccupiedSumConstants { uint cells; } constants;  // whose lists are looked at
#define SCAN_TYPE uint
#include "common/scan.glsl"

void main() {
    uint all = scan_workgroup(is_occupied(gl_GlobalInvocationID.x) ? 1u : 0u).all;
    if (gl_LocalInvocationID.x == 0u) {
        block_sums[gl_WorkGroupID.x] = all;
    }
    for (uint cell = gl_GlobalInvocationID.x; cell < constants.cells; cell += gl_WorkGroupSize.x * gl_NumWorkGroups.x) {
        uint first = cell == 0u ? 0u : cell_ends[cell * BUCKETS - 1u];
        atomicMax(control.longest[level_of(cell)], cell_ends[cell * BUCKETS + BUCKETS - 1u] - first);
    }
}
