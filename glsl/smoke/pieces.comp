// What stays of the ink, and how broad it is. A pixel stays if the piece of a line that it is of, so many pixels along it,
// reaches over enough columns or rows.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const uint ALL_STAY = 0u;
#include "params.glsl"
#include "screen.glsl"
#include "lines.glsl"
#include "pieces.glsl"
layout(local_size_x = 8u * TILE) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 2) readonly buffer InkBits { uint ink_bits[]; };
layout(std430, binding = 3) buffer Lines { float lines[]; };
#include "ink_bits.glsl"
#include "step.glsl"

const uint LANES = 8u * TILE;
const uint PARTS = LANES / WINDOW;                   // invocations for a row of the window
const uint PART = WINDOW / PARTS;                    // pixels for each
const uint SIDE = TILE + 2u * PIECE_REACH + 2u;      // of what is looked at, with an empty border
const uint BEGIN = uint(MARGIN) - PIECE_REACH - 1u;  // of it in the window

// How many pixels the piece of each pixel reaches to the left, right, up and down, itself included: four bits each; 0 where
// there is no ink. Rounds read one half of a word and write the other.
shared uint reached[SIDE * SIDE];
shared uint stays[TILE];
shared uint has_ink;

// The ink of an invocation's part of the window, within reach.
uint ink_of(uvec2 tile, uint row, uint begin) {
    if (row <= BEGIN || row >= BEGIN + SIDE - 1u) {
        return 0u;
    }
    uvec2 beyond = uvec2((1u << BEGIN + 1u) - 1u, ~(~0u >> BEGIN + 1u));
    uvec2 bits = window_row(tile, row, TRACED) & ~beyond;
    return bits[begin / 32u] >> begin % 32u & (1u << PART) - 1u;
}

ivec4 sides_of(uint word) {
    return ivec4(uvec4(word) >> uvec4(0u, 4u, 8u, 12u) & uvec4(0xfu));
}

// What a pixel reaches through itself and those beside it.
uint joined(uint cell, uint half_word) {
    ivec4 farthest = ivec4(0);
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            uint word = reached[int(cell) + int(SIDE) * y + x] >> half_word & 0xffffu;
            farthest = max(farthest, word == 0u ? ivec4(0) : sides_of(word) + ivec4(-x, x, -y, y));
        }
    }
    return uint(farthest.x | farthest.y << 4 | farthest.z << 8 | farthest.w << 12);
}

// Which pixels of a part of the window, whose first cell is `first`, are of pieces that reach far enough.
uint far_reaching(uint bits, uint first, uint lane) {
    for (uint cell = lane; cell < SIDE * SIDE; cell += LANES) {
        reached[cell] = 0u;
    }
    barrier();
    for (uint rest = bits; rest != 0u; rest &= rest - 1u) {
        reached[first + uint(findLSB(rest))] = 0x1111u;
    }
    barrier();
    uint half_word = 0u;
    for (uint round = 0u; round < params.piece_reach; ++round) {
        for (uint rest = bits; rest != 0u; rest &= rest - 1u) {
            uint cell = first + uint(findLSB(rest));
            reached[cell] = reached[cell] & 0xffffu << half_word | joined(cell, half_word) << 16u - half_word;
        }
        half_word = 16u - half_word;
        barrier();
    }
    uint far = 0u;
    for (uint rest = bits; rest != 0u; rest &= rest - 1u) {
        ivec4 sides = sides_of(reached[first + uint(findLSB(rest))] >> half_word);
        int pixels = max(sides.x + sides.y, sides.z + sides.w) - 1;
        far |= float(pixels) >= params.shortest_line ? rest & -rest : 0u;
    }
    return far;
}

// Share of the width that a line has on a step.
float narrowed(float high) {
    return 1.0 - params.outline_taper * (1.0 - clamp((high - LOWEST_STEP) / (FULL_STEP - LOWEST_STEP), 0.0, 1.0));
}

void main() {
    uvec2 tile = tile_at(occupied_tiles[gl_WorkGroupID.x]);
    uint lane = gl_LocalInvocationIndex;
    uint row = lane / PARTS;
    uint begin = lane % PARTS * PART;
    // The tile's own part of the window begins and ends where parts do.
    bool is_own = is_own_row(row) && begin >= uint(MARGIN) && begin < uint(MARGIN) + TILE;
    if (lane < TILE) {
        stays[lane] = 0u;
        has_ink = 0u;
    }
    uint bits = ink_of(tile, row, begin);
    barrier();
    if (is_own && bits != 0u) {
        has_ink = 1u;
    }
    barrier();
    uint found = bits;
    if (ALL_STAY == 0u && has_ink != 0u) {
        found = far_reaching(bits, (row - BEGIN) * SIDE + begin - BEGIN, lane);
    }
    if (is_own && found != 0u) {
        atomicOr(stays[row - uint(MARGIN)], found << begin - uint(MARGIN));
    }
    barrier();
    for (uint pixel = lane; pixel < SLOT_PIXELS; pixel += LANES) {
        uvec2 own = uvec2(pixel % TILE, pixel / TILE);
        uvec2 at = tile * TILE + own;
        if (is_in_picture(at)) {
            float high = lines[pixel_index(at)];
            bool is_line = (stays[own.y] >> own.x & 1u) != 0u;
            lines[pixel_index(at)] = is_line ? (high == SILHOUETTE ? SILHOUETTE : narrowed(high)) : 0.0;
        }
    }
}
