// Smoothed density, along z: the last axis.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "voxel_words.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer DetailSlices { float detail_slices[]; };
layout(std430, binding = 2) writeonly buffer Detailed { float detailed[]; };

void main() {
    uvec3 at = gl_GlobalInvocationID;
    if (at.x >= params.dimensions.x) {
        return;
    }
    uint slice = params.dimensions.x * params.dimensions.y;
    uint in_slice = at.y * params.dimensions.x + at.x;
    int z = int(at.z);
    int window = int(params.detail_window.z);
    float sum = 0.0;
    for (int i = max(z - window, 0); i <= min(z + window, int(params.dimensions.z) - 1); ++i) {
        sum += params.detail_weights[abs(i - z)].z * detail_slices[uint(i) * slice + in_slice];
    }
    detailed[at.z * slice + in_slice] = sum;
}
