// Smoothed density, along x and y: the density's mean by a Gaussian along each axis, whose weights add up to 1. Outside of the
// volume there is none, and what is not finite counts as none. An invocation smooths a block of voxels: each row along x once,
// for all of the block's rows that it reaches.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
#include "voxel_words.glsl"
#include "detail.glsl"
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(std430, binding = 1) readonly buffer Density { float density[]; };
layout(std430, binding = 2) writeonly buffer DetailSlices { float detail_slices[]; };

// Of the block's columns, which begin with voxel x.
vec4 smoothed_along_x(int x, uint row) {
    int window = int(params.detail_window.x);
    uint begin = row * params.dimensions.x;
    vec4 weights = vec4(0.0);
    vec4 sums = vec4(0.0);
    for (int i = x - window; i < x + int(DETAIL_COLUMNS) + window; ++i) {
        weights = vec4(detail_weight(i - x, 0), weights.xyz);
        float value = density[begin + uint(clamp(i, 0, int(params.dimensions.x) - 1))];
        bool counts = uint(i) < params.dimensions.x && is_finite(value);
        sums += weights * (counts ? value : 0.0);
    }
    return sums;
}

void main() {
    ivec3 first = ivec3(gl_GlobalInvocationID * uvec3(DETAIL_COLUMNS, DETAIL_RUN, 1u));
    ivec3 end = ivec3(params.dimensions);
    if (any(greaterThanEqual(first, end))) {
        return;
    }
    int window = int(params.detail_window.y);
    RunWeights weights = RunWeights(vec4(0.0), vec4(0.0));
    vec4 sums[DETAIL_RUN];
    for (uint i = 0u; i < DETAIL_RUN; ++i) {
        sums[i] = vec4(0.0);
    }
    for (int y = first.y - window; y < min(first.y + int(DETAIL_RUN), end.y) + window; ++y) {
        weights = stepped(weights, detail_weight(y - first.y, 1));
        vec4 row = smoothed_along_x(first.x, row_of(uint(clamp(y, 0, end.y - 1)), uint(first.z)));
        row *= y >= 0 && y < end.y ? 1.0 : 0.0;
        for (uint i = 0u; i < DETAIL_RUN; ++i) {
            sums[i] += (i < 4u ? weights.low[i & 3u] : weights.high[i & 3u]) * row;
        }
    }
    for (uint i = 0u; i < DETAIL_RUN; ++i) {
        for (uint j = 0u; j < DETAIL_COLUMNS; ++j) {
            ivec3 at = first + ivec3(j, i, 0);
            if (at.x < end.x && at.y < end.y) {
                detail_slices[row_of(uint(at.y), uint(at.z)) * params.dimensions.x + uint(at.x)] = sums[i][j];
            }
        }
    }
}
