// A round of smoothing of k' where clusters meet, in whole numbers: neighbours may come in any order.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Seams { uint seams[]; };
layout(std430, binding = 2) readonly buffer NeighbourStarts { uint neighbour_starts[]; };
layout(std430, binding = 3) readonly buffer Neighbours { uint neighbours[]; };
layout(std430, binding = 4) readonly buffer Labels { uint labels[]; };
layout(std430, binding = 5) buffer Smooth { int smooth_values[]; };
layout(push_constant) uniform SeamConstants {
    uint from;  // which half of the values is read: 0 or 1; the other is written
} constants;

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= params.counts.w) {
        return;
    }
    uint point = seams[row];
    uint from = constants.from * params.counts.x;
    uint to = params.counts.x - from;
    if (labels[point] == 0u) {
        return;
    }
    int sum = smooth_values[from + point];
    uint first = neighbour_starts[point];
    uint last = neighbour_starts[point + 1u];
    for (uint i = first; i < last; ++i) {
        sum += smooth_values[from + neighbours[i]];
    }
    int count = int(last - first) + 1;
    int rounded = sum + count / 2;
    int mean = rounded >= 0 ? rounded / count : -((count - 1 - rounded) / count);
    smooth_values[to + point] = mean;
}
