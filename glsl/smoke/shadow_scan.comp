// Running sum of the tiles' counts, bucket by bucket, in one workgroup. `cell_ends` becomes where each tile's list begins; filling moves it
// to where the list ends.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) buffer Cells { uint cell_ends[]; };
layout(std430, binding = 2) buffer HistoryBuffer { History history; };

const uint BUCKETS = 64u;

shared uint sums[256];
shared uint longest[16];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint cells = params.light_cells * params.light_faces;
    uint count = cells * BUCKETS;
    uint share = (cells + 255u) / 256u * BUCKETS;
    uint first = min(lane * share, count);
    uint last = min(first + share, count);
    if (lane < 16u) {
        longest[lane] = 0u;
    }
    barrier();
    uint sum = 0u;
    uint in_cell = 0u;
    for (uint i = first; i < last; ++i) {
        uint in_bucket = cell_ends[i];
        cell_ends[i] = sum;
        sum += in_bucket;
        in_cell += in_bucket;
        if (i % BUCKETS == BUCKETS - 1u) {
            // The level of a cell, from its place among the levels of its face.
            uint level = uint(findMSB(3u * (i / BUCKETS % params.light_cells) + 1u)) / 2u;
            atomicMax(longest[level], in_cell);
            in_cell = 0u;
        }
    }
    sums[lane] = sum;
    barrier();
    uint before = 0u;
    for (uint i = 0u; i < lane; ++i) {
        before += sums[i];
    }
    for (uint i = first; i < last; ++i) {
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
