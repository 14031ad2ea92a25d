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
const uint PART = 16u;                           // pixels of the window's rows for each invocation
const uint SIDE = TILE + 2u * PIECE_REACH + 2u;  // of what is looked at, with an empty border
const uint BEGIN = uint(MARGIN) - PIECE_REACH - 1u;  // of it in the window

// How far the piece of each pixel reaches to both sides along an axis, each in a byte that grows outwards. Rounds read one
// half of a word and write the other.
shared uint reached[SIDE * SIDE];
shared uint stays[TILE];
shared uint has_ink;

// Ink in an invocation's part of the window.
struct Part {
    uint bits;
    uvec2 begin;  // in what is looked at
};

Part part_of(uvec2 tile, uint lane) {
    uint row = lane / 4u;
    uint begin = lane % 4u * PART;
    uvec2 words = window_row(tile, row, TRACED);
    uint bits = words[begin / 32u] >> begin % 32u & (1u << PART) - 1u;
    // What is beyond reach is cut.
    uint before = begin == 0u ? BEGIN + 1u : 0u;
    uint behind = begin == 3u * PART ? BEGIN + 1u : 0u;
    bits &= (1u << PART - behind) - (1u << before);
    bool is_in_reach = row > BEGIN && row < BEGIN + SIDE - 1u;
    return Part(is_in_reach ? bits : 0u, uvec2(begin - BEGIN, row - BEGIN));
}

uint cell_of(Part part, uint bit) {
    return part.begin.y * SIDE + part.begin.x + bit;
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

// Which pixels of a part belong to what reaches far enough along an axis.
uint far_reaching(Part part, uint axis, uint lane) {
    barrier();
    for (uint cell = lane; cell < SIDE * SIDE; cell += LANES) {
        reached[cell] = 0u;
    }
    barrier();
    for (uint rest = part.bits; rest != 0u; rest &= rest - 1u) {
        uint bit = uint(findLSB(rest));
        uint at = axis == 0u ? part.begin.x + bit : part.begin.y;
        reached[cell_of(part, bit)] = SIDE - at | at + 1u << 8;
    }
    barrier();
    uint half_word = 0u;
    for (uint round = 0u; round < params.piece_reach; ++round) {
        for (uint rest = part.bits; rest != 0u; rest &= rest - 1u) {
            uint cell = cell_of(part, uint(findLSB(rest)));
            reached[cell] = reached[cell] & 0xffffu << half_word | joined(cell, half_word) << 16u - half_word;
        }
        half_word = 16u - half_word;
        barrier();
    }
    uint far = 0u;
    for (uint rest = part.bits; rest != 0u; rest &= rest - 1u) {
        uint bit = uint(findLSB(rest));
        uint sides = reached[cell_of(part, bit)] >> half_word;
        uint pixels = (sides & 0xffu) + (sides >> 8 & 0xffu) - SIDE;
        far |= float(pixels) >= params.shortest_line ? 1u << bit : 0u;
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
    uint row = lane / 4u;
    uint place = lane % 4u;
    if (lane < TILE) {
        stays[lane] = 0u;
        has_ink = 0u;
    }
    Part part = part_of(tile, lane);
    bool is_own = is_own_row(row) && (place == 1u || place == 2u);
    barrier();
    if (is_own && part.bits != 0u) {
        has_ink = 1u;
    }
    barrier();
    uint found = part.bits;
    if (ALL_STAY == 0u && has_ink != 0u) {
        found = far_reaching(part, 0u, lane);
        found |= far_reaching(part, 1u, lane);
    }
    if (is_own && found != 0u) {
        atomicOr(stays[row - uint(MARGIN)], found << PART * (place - 1u));
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
