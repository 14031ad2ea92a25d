// Radius by the paper's loop (section 3.1): the box grows shell by shell from the particle until it holds an empty voxel.
// A shell at k is at least k * side - offset away along the axis that reaches it, so the loop ends when the next shell
// can hold nothing nearer. The cursor counts the rows (along x) of all shells so far: shell k has (2k + 1)^2 of them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
layout(local_size_x = 64) in;
#include "search.glsl"

uint rows_before(uint shell) {
    return shell * (4u * shell * shell - 1u) / 3u;
}

float shell_distance(vec3 p, ivec3 voxel, int k) {
    float best = INFINITY;
    for (int a = 0; a < 3; ++a) {
        best = min(best, min(along(p, voxel[a] + k, a), along(p, voxel[a] - k, a)));
    }
    return best;
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
    // The shell that the cursor stands in: the cube root is rounded, so begin above it.
    int k = int(0.5 * pow(6.0 * float(cursor), 1.0 / 3.0)) + 2;
    while (k > 0 && rows_before(uint(k)) > cursor) {
        --k;
    }
    int row_of_shell = int(cursor - rows_before(uint(k)));
    for (uint iteration = 0u; iteration < constants.iterations && cursor < constants.last; ++iteration) {
        int side = 2 * k + 1;
        if (row_of_shell == side * side) {
            ++k;
            row_of_shell = 0;
            side += 2;
        }
        if (row_of_shell == 0 && shell_distance(p, voxel, k) >= best) {
            cursor = constants.last;
            break;
        }
        int y = voxel.y + row_of_shell % side - k;
        int z = voxel.z + row_of_shell / side - k;
        if (y >= 0 && y < int(params.dimensions.y) && z >= 0 && z < int(params.dimensions.z)) {
            float dx = INFINITY;
            if (abs(y - voxel.y) == k || abs(z - voxel.z) == k) {
                uint row = params.levels[0].first_word + row_of(uint(y), uint(z)) * params.row_words;
                float reach = max(along(p, voxel.x + k, 0), along(p, voxel.x - k, 0));
                dx = nearest_in_row(row, 0u, p, voxel.x, reach);
            } else {
                ivec3 left = ivec3(voxel.x - k, y, z);
                ivec3 right = ivec3(voxel.x + k, y, z);
                dx = is_inside(left) && !is_occupied(left) ? along(p, left.x, 0) : INFINITY;
                dx = is_inside(right) && !is_occupied(right) ? min(dx, along(p, right.x, 0)) : dx;
            }
            best = min(best, combined(dx, along(p, y, 1), along(p, z, 2)));
        }
        ++cursor;
        ++row_of_shell;
    }
    keep_search(slot, p, cursor, best);
}
