// A round of smoothing of k' where clusters meet, in whole numbers of 1 - k': neighbours may come in any order.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Seams { uint seams[]; };
layout(std430, binding = 2) readonly buffer NeighbourStarts { uint neighbour_starts[]; };
layout(std430, binding = 3) readonly buffer Neighbours { uint neighbours[]; };
layout(std430, binding = 4) readonly buffer Labels { uint labels[]; };
layout(std430, binding = 5) buffer Smooth { uint smooth_values[]; };
layout(push_constant) uniform SeamConstants {
    uint from;  // which half of the values is read: 0 or 1; the other is written
} constants;

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= params.seam_points) {
        return;
    }
    uint point = seams[row];
    uint from = constants.from * params.points;
    uint to = params.points - from;
    if (labels[point] == 0u) {
        return;
    }
    uint sum = smooth_values[from + point];
    uint first = neighbour_starts[point];
    uint last = neighbour_starts[point + 1u];
    for (uint i = first; i < last; ++i) {
        sum += smooth_values[from + neighbours[i]];
    }
    uint count = last - first + 1u;
    // What leads stays whole: nothing is drawn back farther.
    smooth_values[to + point] = min((sum + count / 2u) / count, smooth_values[from + point]);
}
