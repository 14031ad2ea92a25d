// Through which cells the threshold passes. A cell is the box between the centres of eight voxels, the empty ones around the
// volume included; of the density between them, which is trilinear, some is above the threshold and some is not exactly where
// that is so of the eight. Cell (x, y, z) ends at the centre of voxel (x, y, z). A bit each, rows along x as occupancy has
// them; a word of a level above is the OR of the words of 2 x 2 rows along y and z. A workgroup makes four levels of 8 x 8
// rows, or the three above one that is there.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "voxel_words.glsl"
#include "../common/bits.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Occupancy { uint occupancy[]; };
layout(std430, binding = 2) buffer Crossings { uint crossings[]; };
layout(push_constant) uniform CrossingsConstants { uint level; } constants;  // whose rows a workgroup begins with

shared uint words[CROSSING_ROWS * CROSSING_ROWS];

uint occupied(int word, ivec2 row) {
    bool inside = all(greaterThanEqual(row, ivec2(0))) && all(lessThan(row, ivec2(params.dimensions.yz)));
    bool exists = inside && word >= 0 && word < int(params.row_words);
    return exists ? occupancy[row_of(uint(row.x), uint(row.y)) * params.row_words + uint(word)] : 0u;
}

uint crossed(int word, ivec2 row) {
    uint any_ = 0u;
    uint all_ = 0xffffffffu;
    for (int i = 0; i < 4; ++i) {
        ivec2 of = row - ivec2(i & 1, i >> 1);
        uint at = occupied(word, of);
        uint before = at << 1u | occupied(word - 1, of) >> 31u;
        any_ |= at | before;
        all_ &= at & before;
    }
    return any_ & ~all_;
}

uint at_level(uint level, uint word, uvec2 row) {
    PyramidLevel from = params.levels[level];
    bool exists = row.x < from.rows_y && row.y < from.rows_z;
    return exists ? crossings[from.first_word + (row.y * from.rows_y + row.x) * params.crossing_row_words + word] : 0u;
}

void put(uint level, uint word, uvec2 row, uint bits) {
    PyramidLevel to = params.levels[level];
    if (row.x < to.rows_y && row.y < to.rows_z) {
        crossings[to.first_word + (row.y * to.rows_y + row.x) * params.crossing_row_words + word] = bits;
    }
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint word = gl_WorkGroupID.x;
    uvec2 row = gl_WorkGroupID.yz * CROSSING_ROWS + uvec2(lane % CROSSING_ROWS, lane / CROSSING_ROWS);
    uint bits = 0u;
    if (constants.level > 0u) {
        bits = at_level(constants.level, word, row);
    } else if (row.x < params.levels[0].rows_y && row.y < params.levels[0].rows_z) {
        bits = crossed(int(word), ivec2(row));
        put(0u, word, row, bits);
    }
    words[lane] = bits;
    for (uint above = 1u; above <= CROSSING_LEVELS && constants.level + above < MAX_LEVELS; ++above) {
        barrier();
        uint side = CROSSING_ROWS >> above;
        bool makes = lane < side * side;
        uvec2 own = uvec2(lane % side, lane / side);
        if (makes) {
            uint low = own.y * 4u * side + own.x * 2u;
            bits = words[low] | words[low + 1u] | words[low + 2u * side] | words[low + 2u * side + 1u];
            put(constants.level + above, word, gl_WorkGroupID.yz * side + own, bits);
        }
        barrier();
        if (makes) {
            words[lane] = bits;
        }
    }
}
