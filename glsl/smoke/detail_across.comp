// Smoothed density, along x and y: the density's mean by a Gaussian along each axis, whose weights add up to 1. Outside of the
// volume there is none, and what is not finite counts as none. An invocation makes some voxels that are neighbours along y: it
// smooths each row along x once and adds it to all of them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
#include "voxel_words.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Density { float density[]; };
layout(std430, binding = 2) writeonly buffer DetailSlices { float detail_slices[]; };

float smoothed_along_x(int x, uint row) {
    int window = int(params.detail_window.x);
    int first = int(row * params.dimensions.x);
    float sum = 0.0;
    for (int i = max(x - window, 0); i <= min(x + window, int(params.dimensions.x) - 1); ++i) {
        float value = density[first + i];
        sum += params.detail_weights[abs(i - x)].x * (is_finite(value) ? value : 0.0);
    }
    return sum;
}

void main() {
    uvec3 at = gl_GlobalInvocationID * uvec3(1u, DETAIL_RUN, 1u);
    if (at.x >= params.dimensions.x) {
        return;
    }
    int window = int(params.detail_window.y);
    int first = int(at.y);
    int last = min(first + int(DETAIL_RUN), int(params.dimensions.y)) - 1;
    float sums[DETAIL_RUN];
    for (uint i = 0u; i < DETAIL_RUN; ++i) {
        sums[i] = 0.0;
    }
    for (int y = max(first - window, 0); y <= min(last + window, int(params.dimensions.y) - 1); ++y) {
        float value = smoothed_along_x(int(at.x), row_of(uint(y), at.z));
        for (uint i = 0u; i < DETAIL_RUN; ++i) {
            int distance = abs(y - first - int(i));
            float weight = params.detail_weights[min(distance, int(MOST_DETAIL_WINDOW))].y;
            sums[i] += distance <= window ? weight * value : 0.0;
        }
    }
    for (uint i = 0u; i < DETAIL_RUN; ++i) {
        if (first + int(i) <= last) {
            detail_slices[row_of(at.y + i, at.z) * params.dimensions.x + at.x] = sums[i];
        }
    }
}
