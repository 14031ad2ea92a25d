// Ink of steps. It goes on from strong pixels along weak ones, by one a round in all directions. Then a pixel stays if the
// piece of a line that it is of, so many pixels along it, reaches over enough columns or rows; and lines have a width.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const uint ALL_STAY = 0u;
#include "params.glsl"
#include "screen.glsl"
#include "lines.glsl"
#include "ink_bits.glsl"
layout(local_size_x = 8u * TILE) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 2) readonly buffer InkBits { uint ink_bits[]; };
layout(std430, binding = 3) buffer Lines { float lines[]; };

const uint LANES = 8u * TILE;
const uint WINDOW = 3u * TILE;                   // what is seen: the tile and those around it
const uint PARTS = 4u;                           // invocations for a row of what pieces are looked for in
const uint PART = 2u * TILE / PARTS;             // pixels for each
const uint SIDE = TILE + 2u * PIECE_REACH + 2u;  // of what is looked at there, with an empty border
const uint BEGIN = TILE - PIECE_REACH - 1u;      // of it in the window

// Rows of the window, with an empty one above and below.
shared uint ink[3u * (WINDOW + 2u)];
// How many pixels the piece of each pixel reaches to the left, right, up and down, itself included: four bits each; 0 where
// there is no ink. Rounds read one half of a word and write the other.
shared uint reached[SIDE * SIDE];
shared uint stays[TILE];
shared uint has_ink;
shared uint has_weak;

uint ink_word(ivec2 tile, uint row, uint plane) {
    bool is_tile = all(greaterThanEqual(tile, ivec2(0))) && all(lessThan(tile, ivec2(params.tiles)));
    return is_tile ? ink_bits[INK_WORDS * uint(tile.y * int(params.tiles.x) + tile.x) + TILE * plane + row] : 0u;
}

// A row of the window, from left to right.
uvec3 window_row(uvec2 tile, uint row, uint plane) {
    ivec2 middle = ivec2(tile) + ivec2(0, int(row / TILE) - 1);
    return uvec3(ink_word(middle - ivec2(1, 0), row % TILE, plane), ink_word(middle, row % TILE, plane),
                 ink_word(middle + ivec2(1, 0), row % TILE, plane));
}

uvec3 ink_row(uint row) {
    return uvec3(ink[3u * row], ink[3u * row + 1u], ink[3u * row + 2u]);
}

void set_ink_row(uint row, uvec3 bits) {
    ink[3u * row] = bits.x;
    ink[3u * row + 1u] = bits.y;
    ink[3u * row + 2u] = bits.z;
}

// With the pixels beside, left and right.
uvec3 broadened(uvec3 row) {
    return row | row << 1 | uvec3(0u, row.xy >> 31) | row >> 1 | uvec3(row.yz << 31, 0u);
}

// Fills the rows of the window with ink, and says whether the tile may have any.
void trace(uvec2 tile, uint row) {
    bool has_row = row < WINDOW;
    uvec3 weak = has_row ? window_row(tile, row, WEAK) : uvec3(0u);
    uvec3 own = has_row ? window_row(tile, row, STRONG) : uvec3(0u);
    if (row < WINDOW + 2u) {
        set_ink_row(row, uvec3(0u));
    }
    if (row == 0u) {
        has_ink = 0u;
        has_weak = 0u;
    }
    barrier();
    if (has_row) {
        set_ink_row(row + 1u, own);
        if (row / TILE == 1u && weak.y != 0u) {
            has_ink = 1u;
        }
        if (weak != own) {
            has_weak = 1u;
        }
    }
    barrier();
    if (has_ink != 0u && has_weak != 0u) {
        for (uint round = 0u; round < TRACE_REACH; ++round) {
            if (has_row) {
                own |= broadened(ink_row(row) | ink_row(row + 1u) | ink_row(row + 2u)) & weak;
            }
            barrier();
            if (has_row) {
                set_ink_row(row + 1u, own);
            }
            barrier();
        }
    }
}

// The ink of an invocation's part of the window, within reach.
uint ink_of(uint row, uint begin) {
    if (row <= BEGIN || row >= BEGIN + SIDE - 1u) {
        return 0u;
    }
    uint bits = ink_row(row + 1u)[begin / 32u] >> begin % 32u & (1u << PART) - 1u;
    uint before = BEGIN + 1u > begin ? BEGIN + 1u - begin : 0u;
    uint end = min(BEGIN + SIDE - 1u - begin, PART);
    return bits & (1u << end) - (1u << before);
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
    trace(tile, lane);
    // The middle of the window, of twice a tile's side: the tile's own part of it begins and ends where parts do.
    uint row = TILE / 2u + lane / PARTS;
    uint begin = TILE / 2u + lane % PARTS * PART;
    bool is_own = row / TILE == 1u && begin / TILE == 1u;
    if (lane < TILE) {
        stays[lane] = 0u;
    }
    uint found = ink_of(row, begin);
    barrier();
    if (ALL_STAY == 0u && has_ink != 0u) {
        found = far_reaching(found, (row - BEGIN) * SIDE + begin - BEGIN, lane);
    }
    if (is_own && found != 0u) {
        atomicOr(stays[row - TILE], found << begin - TILE);
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
