// One bit a voxel: density > threshold. Counts, for each run of words, the voxels that a birth may choose.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "voxel_words.glsl"
layout(local_size_x = BIRTH_BLOCK) in;
layout(std430, binding = 1) readonly buffer Density { float density[]; };
layout(std430, binding = 2) writeonly buffer Occupancy { uint occupancy[]; };
layout(std430, binding = 3) writeonly buffer BirthCounts { uint birth_counts[]; };

shared uint partial[gl_WorkGroupSize.x];

void main() {
    uint word = gl_GlobalInvocationID.x;
    uint births = 0u;
    if (word < params.row_words * params.dimensions.y * params.dimensions.z) {
        uint row = word / params.row_words;
        uint start = word % params.row_words * WORD_VOXELS;
        uint count = min(WORD_VOXELS, params.dimensions.x - start);
        uint first = row * params.dimensions.x + start;
        uint bits = 0u;
        for (uint i = 0u; i < count; ++i) {
            // Everything that is not above the threshold is empty, NaN included.
            if (density[first + i] > params.threshold) {
                bits |= 1u << i;
            }
        }
        occupancy[word] = bits;
        int y = int(row % params.dimensions.y);
        int z = int(row / params.dimensions.y);
        ivec3 low = params.emitter_first.xyz;
        ivec3 high = params.emitter_last.xyz;
        if (y >= low.y && y <= high.y && z >= low.z && z <= high.z) {
            births = uint(bitCount(bits & voxel_bits(int(start), low.x, high.x)));
        }
    }
    uint lane = gl_LocalInvocationID.x;
    partial[lane] = births;
    for (uint width = gl_WorkGroupSize.x / 2u; width > 0u; width /= 2u) {
        barrier();
        if (lane < width) {
            partial[lane] += partial[lane + width];
        }
    }
    if (lane == 0u) {
        birth_counts[gl_WorkGroupID.x] = partial[0];
    }
}
