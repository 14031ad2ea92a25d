// The next level of the occupancy pyramid: a word is the AND of the words of 2 x 2 rows (along y and z), so that a 0 says
// "some voxel at this x is empty". What lies outside the volume counts as full here; the search knows the outside.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) buffer Occupancy { uint occupancy[]; };
layout(push_constant) uniform PyramidConstants { uint level; } constants;

uint word_at(uint level, uint x, uint y, uint z) {
    uvec4 rows = params.levels[level];
    if (y >= rows.y || z >= rows.z) {
        return 0xffffffffu;
    }
    uint word = occupancy[rows.x + (z * rows.y + y) * params.grid.w + x];
    uint used = params.grid.x - x * 32u;
    return level == 0u && used < 32u ? word | 0xffffffffu << used : word;
}

void main() {
    uvec4 rows = params.levels[constants.level];
    uint index = gl_GlobalInvocationID.x;
    if (index >= params.grid.w * rows.y * rows.z) {
        return;
    }
    uint x = index % params.grid.w;
    uint y = index / params.grid.w % rows.y * 2u;
    uint z = index / params.grid.w / rows.y * 2u;
    uint below = constants.level - 1u;
    occupancy[rows.x + index] =
        word_at(below, x, y, z) & word_at(below, x, y + 1u, z) & word_at(below, x, y, z + 1u)
        & word_at(below, x, y + 1u, z + 1u);
}
