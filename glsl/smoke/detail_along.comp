// Smoothed density, along z: the last axis.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "voxel_words.glsl"
#include "detail.glsl"
layout(local_size_x = 16, local_size_y = 4) in;
layout(std430, binding = 1) readonly buffer DetailSlices { float detail_slices[]; };
layout(std430, binding = 2) writeonly buffer Detailed { float detailed[]; };

void main() {
    uvec2 column = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(column, params.dimensions.xy))) {
        return;
    }
    uint slice = params.dimensions.x * params.dimensions.y;
    uint in_slice = column.y * params.dimensions.x + column.x;
    int first = int(gl_GlobalInvocationID.z * DETAIL_RUN);
    int end = int(params.dimensions.z);
    int window = int(params.detail_window.z);
    RunWeights weights = RunWeights(vec4(0.0), vec4(0.0));
    vec4 low = vec4(0.0);
    vec4 high = vec4(0.0);
    for (int z = first - window; z < min(first + int(DETAIL_RUN), end) + window; ++z) {
        weights = stepped(weights, detail_weight(z - first, 2));
        float value = detail_slices[uint(clamp(z, 0, end - 1)) * slice + in_slice];
        value = z >= 0 && z < end ? value : 0.0;
        low += weights.low * value;
        high += weights.high * value;
    }
    for (uint i = 0u; i < DETAIL_RUN; ++i) {
        if (first + int(i) < end) {
            detailed[uint(first + int(i)) * slice + in_slice] = i < 4u ? low[i & 3u] : high[i & 3u];
        }
    }
}
