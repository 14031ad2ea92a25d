// Follows lines to where they fade: ink grows along weak pixels, by one a round in all directions.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "screen.glsl"
layout(local_size_x = 2 * TILE) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 2) buffer InkBits { uint ink_bits[]; };
#include "ink_bits.glsl"

shared uvec2 ink[WINDOW + 2u];  // with an empty row above and below
shared uint has_weak;

// With the pixels beside, left and right.
uvec2 broadened(uvec2 row) {
    uvec2 right = uvec2(row.x << 1, row.y << 1 | row.x >> 31);
    uvec2 left = uvec2(row.x >> 1 | row.y << 31, row.y >> 1);
    return row | left | right;
}

void main() {
    uint index = occupied_tiles[gl_WorkGroupID.x];
    uvec2 tile = tile_at(index);
    uint row = gl_LocalInvocationIndex;
    uvec2 weak = window_row(tile, row, WEAK);
    uvec2 own = window_row(tile, row, STRONG);
    ink[row + 1u] = own;
    if (row == 0u) {
        ink[0] = uvec2(0u);
        ink[WINDOW + 1u] = uvec2(0u);
        has_weak = 0u;
    }
    barrier();
    if (is_own_row(row) && own_part(weak) != own_part(own)) {
        atomicOr(has_weak, 1u);
    }
    barrier();
    if (has_weak != 0u) {
        for (uint round = 0u; round < TRACE_REACH; ++round) {
            own |= broadened(ink[row] | ink[row + 1u] | ink[row + 2u]) & weak;
            barrier();
            ink[row + 1u] = own;
            barrier();
        }
    }
    if (is_own_row(row)) {
        ink_bits[INK_WORDS * index + TILE * TRACED + row - uint(MARGIN)] = own_part(own);
    }
}
