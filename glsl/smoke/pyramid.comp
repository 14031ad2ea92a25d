// The next level of the occupancy pyramid: a word is the AND of the words of 2 x 2 rows (along y and z), so that a 0 says
// "some voxel at this x is empty". What lies outside the volume counts as full here; the search knows the outside.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "voxel_words.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) buffer Occupancy { uint occupancy[]; };
layout(push_constant) uniform PyramidConstants { uint level; } constants;

uint word_at(uint level, uint x, uint y, uint z) {
    PyramidLevel from = params.levels[level];
    if (y >= from.rows_y || z >= from.rows_z) {
        return 0xffffffffu;
    }
    uint word = occupancy[from.first_word + (z * from.rows_y + y) * params.row_words + x];
    uint used = params.dimensions.x - x * WORD_VOXELS;
    return level == 0u && used < WORD_VOXELS ? word | 0xffffffffu << used : word;
}

void main() {
    PyramidLevel to = params.levels[constants.level];
    uint index = gl_GlobalInvocationID.x;
    if (index >= params.row_words * to.rows_y * to.rows_z) {
        return;
    }
    uint x = index % params.row_words;
    uint y = index / params.row_words % to.rows_y * 2u;
    uint z = index / params.row_words / to.rows_y * 2u;
    uint below = constants.level - 1u;
    occupancy[to.first_word + index] =
        word_at(below, x, y, z) & word_at(below, x, y + 1u, z) & word_at(below, x, y, z + 1u)
        & word_at(below, x, y + 1u, z + 1u);
}
