// What stays of the ink, and how broad it is. A pixel stays if the piece of a line that it is of, so many pixels along it,
// reaches over enough columns or rows.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const uint ALL_STAY = 0u;
#include "params.glsl"
#include "screen.glsl"
#include "lines.glsl"
#include "pieces.glsl"
layout(local_size_x = 2u * TILE) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 2) readonly buffer InkBits { uint ink_bits[]; };
layout(std430, binding = 3) buffer Lines { float lines[]; };
#include "ink_bits.glsl"
#include "step.glsl"

const uint SIDE = TILE + 2u * PIECE_REACH + 2u;      // of what is looked at, with an empty border
const uint BEGIN = uint(MARGIN) - PIECE_REACH - 1u;  // of it in the window

// How far the piece of each pixel reaches to both sides along an axis, each in a byte that grows outwards. Rounds read one
// half of a word and write the other.
shared uint reached[SIDE * SIDE];
shared uint stays[TILE];
shared uint has_ink;

// The ink of a row of the window, within reach.
uvec2 row_of(uvec2 tile, uint row) {
    if (row <= BEGIN || row >= BEGIN + SIDE - 1u) {
        return uvec2(0u);
    }
    uvec2 beyond = uvec2((1u << BEGIN + 1u) - 1u, ~(~0u >> BEGIN + 1u));
    return window_row(tile, row, TRACED) & ~beyond;
}

uint cell_of(uint row, uint column) {
    return (row - BEGIN) * SIDE + column - BEGIN;
}

// The farthest of a cell and those beside it.
uint joined(uint cell, uint half_word) {
    uvec2 farthest = uvec2(0u);
    for (uint y = 0u; y < 3u; ++y) {
        for (uint x = 0u; x < 3u; ++x) {
            uint sides = reached[cell + SIDE * y + x - SIDE - 1u] >> half_word;
            farthest = max(farthest, uvec2(sides & 0xffu, sides >> 8 & 0xffu));
        }
    }
    return farthest.x | farthest.y << 8;
}

// For each pixel of a row's ink, as `column`.
#define FOR_INK(bits, column) \
    for (uint word = 0u; word < 2u; ++word) \
        for (uint rest = bits[word], column; rest != 0u && (column = 32u * word + uint(findLSB(rest))) < WINDOW; rest &= rest - 1u)

// Which pixels of a row's ink belong to what reaches far enough along an axis.
uvec2 far_reaching(uvec2 bits, uint row, uint axis) {
    barrier();
    for (uint cell = row; cell < SIDE * SIDE; cell += WINDOW) {
        reached[cell] = 0u;
    }
    barrier();
    FOR_INK(bits, column) {
        uint at = (axis == 0u ? column : row) - BEGIN;
        reached[cell_of(row, column)] = SIDE - at | at + 1u << 8;
    }
    barrier();
    uint half_word = 0u;
    for (uint round = 0u; round < params.piece_reach; ++round) {
        FOR_INK(bits, column) {
            uint cell = cell_of(row, column);
            reached[cell] = reached[cell] & 0xffffu << half_word | joined(cell, half_word) << 16u - half_word;
        }
        half_word = 16u - half_word;
        barrier();
    }
    uvec2 far = uvec2(0u);
    FOR_INK(bits, column) {
        uint sides = reached[cell_of(row, column)] >> half_word;
        uint pixels = (sides & 0xffu) + (sides >> 8 & 0xffu) - SIDE;
        far[word] |= float(pixels) >= params.shortest_line ? rest & -rest : 0u;
    }
    return far;
}

// Share of the width that a line has on a step.
float narrowed(float high) {
    return 1.0 - params.outline_taper * (1.0 - clamp((high - LOWEST_STEP) / (FULL_STEP - LOWEST_STEP), 0.0, 1.0));
}

void main() {
    uvec2 tile = tile_at(occupied_tiles[gl_WorkGroupID.x]);
    uint row = gl_LocalInvocationIndex;
    if (row == 0u) {
        has_ink = 0u;
    }
    uvec2 bits = row_of(tile, row);
    barrier();
    if (is_own_row(row) && own_part(bits) != 0u) {
        has_ink = 1u;
    }
    barrier();
    uvec2 found = bits;
    if (ALL_STAY == 0u && has_ink != 0u) {
        found = far_reaching(bits, row, 0u);
        found |= far_reaching(bits, row, 1u);
    }
    if (is_own_row(row)) {
        stays[row - uint(MARGIN)] = own_part(found);
    }
    barrier();
    for (uint pixel = row; pixel < SLOT_PIXELS; pixel += WINDOW) {
        uvec2 own = uvec2(pixel % TILE, pixel / TILE);
        uvec2 at = tile * TILE + own;
        if (is_in_picture(at)) {
            float high = lines[pixel_index(at)];
            bool is_line = (stays[own.y] >> own.x & 1u) != 0u;
            lines[pixel_index(at)] = is_line ? (high == SILHOUETTE ? SILHOUETTE : narrowed(high)) : 0.0;
        }
    }
}
