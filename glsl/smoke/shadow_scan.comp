// Exclusive prefix sum of the tiles' counts, bucket by bucket, in one workgroup. `cell_ends` becomes where each tile's
// list begins; filling moves it to where the list ends.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "lanes.glsl"
#include "cells.glsl"
layout(std430, binding = 1) buffer Cells { uint cell_ends[]; };
layout(std430, binding = 2) buffer HistoryBuffer { History history; };

shared uint sums[gl_WorkGroupSize.x];
shared uint longest[MAX_LIGHT_LEVELS];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uvec2 run = own_run(params.light_cells * params.light_faces) * BUCKETS;
    if (lane < MAX_LIGHT_LEVELS) {
        longest[lane] = 0u;
    }
    barrier();
    uint sum = 0u;
    uint in_cell = 0u;
    for (uint i = run.x; i < run.y; ++i) {
        uint in_bucket = cell_ends[i];
        cell_ends[i] = sum;
        sum += in_bucket;
        in_cell += in_bucket;
        if (i % BUCKETS == BUCKETS - 1u) {
            atomicMax(longest[level_of(i / BUCKETS)], in_cell);
            in_cell = 0u;
        }
    }
    sums[lane] = sum;
    barrier();
    uint before = 0u;
    for (uint i = 0u; i < lane; ++i) {
        before += sums[i];
    }
    for (uint i = run.x; i < run.y; ++i) {
        cell_ends[i] += before;
    }
    if (lane == 0u) {
        uint total = 0u;
        for (uint level = 0u; level < params.light_levels; ++level) {
            total += longest[level];
        }
        history.longest = total;
    }
}
