// Radius by the occupancy pyramid: rows (along x) in Morton order of (y, z), whole blocks of rows passed over where they
// are too far or hold no empty voxel near enough. The cursor alone says where the walk stands.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
layout(local_size_x = 64) in;
#include "search.glsl"
#include "morton.glsl"

// Distance from p to the nearest centre of voxels first .. last along an axis.
float to_range(vec3 p, int first, int last, int axis) {
    return max(0.0, max(voxel_centre(first, axis) - p[axis], p[axis] - voxel_centre(last, axis)));
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= params.particles) {
        return;
    }
    vec3 p = position_of(slot);
    ivec3 voxel = voxel_of(p);
    uint cursor;
    float best;
    if (!resume_search(slot, p, voxel, cursor, best)) {
        return;
    }
    if (constants.part == 0u) {
        uint own = params.levels[0].first_word + row_of(uint(voxel.y), uint(voxel.z)) * params.row_words;
        float dx = nearest_in_row(own, 0u, p, voxel.x, best);
        best = min(best, combined(dx, along(p, voxel.y, 1), along(p, voxel.z, 2)));
    }
    uint top = uint(findMSB(constants.last)) / 2u;
    uint level = cursor == 0u ? top : min(top, uint(findLSB(cursor)) / 2u);
    for (uint iteration = 0u; iteration < constants.iterations && cursor < constants.last; ++iteration) {
        int y = int(even_bits(cursor) >> level);
        int z = int(even_bits(cursor >> 1) >> level);
        PyramidLevel nodes = params.levels[level];
        bool enter = y < int(nodes.rows_y) && z < int(nodes.rows_z);
        float distance = 0.0;
        if (enter) {
            int last_y = min((y + 1 << level) - 1, int(params.dimensions.y) - 1);
            int last_z = min((z + 1 << level) - 1, int(params.dimensions.z) - 1);
            float dy = to_range(p, y << level, last_y, 1);
            float dz = to_range(p, z << level, last_z, 2);
            enter = combined(0.0, dy, dz) < best;
            if (enter) {
                uint row = nodes.first_word + (uint(z) * nodes.rows_y + uint(y)) * params.row_words;
                distance = combined(nearest_in_row(row, level, p, voxel.x, best), dy, dz);
                enter = distance < best;
            }
        }
        if (enter && level > 0u) {
            level -= 1u;
            continue;
        }
        best = enter ? distance : best;
        cursor += 1u << 2u * level;
        level = min(top, uint(findLSB(cursor)) / 2u);
    }
    keep_search(slot, p, cursor, best);
}
