// Exclusive prefix sum of the cells' counts, bucket by bucket, in one workgroup. `cell_ends` becomes where each bucket's list
// begins; filling moves it to where the list ends. Finds how long the longest list of a tile can be, and cuts the work on lists into parts
// that keep each invocation within its loop budget.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) buffer Cells { uint cell_ends[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(push_constant) uniform ScanConstants {
    uint budget;   // loop iterations that an invocation may take
    uint base;     // iterations that a repetition takes besides its entries
    uint visit;    // iterations that an entry takes besides its render particles
    uint eighths;  // eighths of an iteration that each of those takes
} constants;
#include "share.glsl"

shared uint longest[MAX_CELL_LEVELS];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint buckets = params.bucket_count;
    uvec2 share = share_of_list(params.cell_count) * buckets;
    if (lane < MAX_CELL_LEVELS) {
        longest[lane] = 0u;
    }
    barrier();
    uint sum = 0u;
    uint in_cell = 0u;
    uint level = 0u;
    for (uint i = share.x; i < share.y; ++i) {
        uint in_bucket = cell_ends[i];
        cell_ends[i] = sum;
        sum += in_bucket;
        in_cell += in_bucket;
        if (i % buckets == buckets - 1u) {
            uint cell = i / buckets;
            while (cell >= params.cell_levels[level].end) {
                ++level;
            }
            atomicMax(longest[level], in_cell);
            in_cell = 0u;
        }
    }
    uint before = prefix_sum(sum).x;
    for (uint i = share.x; i < share.y; ++i) {
        cell_ends[i] += before;
    }
    if (lane == 0u) {
        uint total = 0u;
        for (uint l = 0u; l < params.cell_level_count; ++l) {
            total += longest[l];
        }
        uint visit = constants.visit + (control.most * constants.eighths + 7u) / 8u;
        uint entries_at_once = max((constants.budget - constants.base) / visit, 1u);
        uint segments = max((total + entries_at_once - 1u) / entries_at_once, 1u);
        uint repetitions = segments > 1u ? 1u : max(constants.budget / (constants.base + total * visit), 1u);
        control.segments = segments;
        control.segment_entries = segments > 1u ? entries_at_once : max(total, 1u);
        control.part_repetitions = min(repetitions, params.iterations);
        control.listed = total;
    }
}
