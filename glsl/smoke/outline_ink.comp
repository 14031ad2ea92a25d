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
const uint WINDOW_WORDS = 3u * (WINDOW + 2u);    // with an empty row above and below
const uint SIDE = TILE + 2u * PIECE_REACH + 2u;  // of what pieces are looked for in, with an empty border
const uint BEGIN = TILE - PIECE_REACH - 1u;      // of it in the window

// Rows of the window. Rounds of tracing read one half and write the other.
shared uint ink[2u * WINDOW_WORDS];
shared uint goes_on[TRACE_REACH];  // whether a round has found any
// How many pixels the piece of each pixel reaches to the left, right, up and down, itself included: four bits each; 0 where
// there is no ink. Rounds read one half of a word and write the other.
shared uint reached[SIDE * SIDE];
// Cells of it with ink: a list, so that all invocations have as much to do.
shared uint inked[SIDE * SIDE];
shared uint inked_count;
shared uint own_weak[TILE];
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

uvec3 ink_row(uint begin, uint row) {
    uint word = begin + 3u * row;
    return uvec3(ink[word], ink[word + 1u], ink[word + 2u]);
}

void set_ink_row(uint begin, uint row, uvec3 bits) {
    uint word = begin + 3u * row;
    ink[word] = bits.x;
    ink[word + 1u] = bits.y;
    ink[word + 2u] = bits.z;
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
    if (row < 4u) {
        set_ink_row(row / 2u * WINDOW_WORDS, row % 2u * (WINDOW + 1u), uvec3(0u));
    }
    if (row < TRACE_REACH) {
        goes_on[row] = 0u;
    }
    if (row == 0u) {
        has_ink = 0u;
        has_weak = 0u;
        inked_count = 0u;
    }
    barrier();
    if (has_row) {
        set_ink_row(0u, row + 1u, broadened(own));
        if (row / TILE == 1u) {
            own_weak[row - TILE] = weak.y;
            if (weak.y != 0u) {
                has_ink = 1u;
            }
        }
        if (weak != own) {
            has_weak = 1u;
        }
    }
    barrier();
    if (has_ink != 0u && has_weak != 0u) {
        uint begin = 0u;
        for (uint round = 0u; round < params.trace_reach; ++round) {
            if (has_row) {
                uvec3 beside = ink_row(begin, row) | broadened(own) | ink_row(begin, row + 2u);
                uvec3 found = own | beside & weak;
                if (found != own) {
                    goes_on[round] = 1u;
                }
                own = found;
                set_ink_row(WINDOW_WORDS - begin, row + 1u, broadened(own));
            }
            begin = WINDOW_WORDS - begin;
            barrier();
            if (goes_on[round] == 0u) {
                break;
            }
        }
    }
    if (has_row) {
        set_ink_row(0u, row + 1u, own);
    }
    barrier();
}

// The ink of a part of a row of the window, as far as it may matter to the tile's.
uint ink_of(uint row, uint column) {
    uint begin = TILE - params.piece_reach;
    uint end = 2u * TILE + params.piece_reach;
    if (row < begin || row >= end) {
        return 0u;
    }
    uint bits = ink[3u * (row + 1u) + column / 32u] >> column % 32u & (1u << PART) - 1u;
    uint before = uint(max(int(begin) - int(column), 0));
    uint behind = uint(clamp(int(end) - int(column), 0, int(PART)));
    return bits & (1u << behind) - (1u << min(before, behind));
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

// Finds what may matter to the tile's ink. That is in the middle of the window, of twice a tile's side.
void list_ink(uint lane) {
    uvec2 first = TILE / 2u + uvec2(lane % PARTS * PART, lane / PARTS);
    uint bits = ink_of(first.y, first.x);
    uint place = bits != 0u ? atomicAdd(inked_count, uint(bitCount(bits))) : 0u;
    for (; bits != 0u; bits &= bits - 1u) {
        uint cell = (first.y - BEGIN) * SIDE + first.x + uint(findLSB(bits)) - BEGIN;
        reached[cell] = 0x1111u;
        inked[place++] = cell;
    }
}

// Finds which pixels of the tile are of pieces that reach far enough.
void find_far_reaching(uint lane) {
    uint unused = (PIECE_REACH - params.piece_reach) * SIDE;
    for (uint cell = unused + lane; cell < SIDE * SIDE - unused; cell += LANES) {
        reached[cell] = 0u;
    }
    barrier();
    list_ink(lane);
    barrier();
    uint count = inked_count;
    uint half_word = 0u;
    for (uint round = 0u; round < params.piece_reach; ++round) {
        for (uint i = lane; i < count; i += LANES) {
            uint cell = inked[i];
            reached[cell] = reached[cell] & 0xffffu << half_word | joined(cell, half_word) << 16u - half_word;
        }
        half_word = 16u - half_word;
        barrier();
    }
    for (uint i = lane; i < count; i += LANES) {
        uint cell = inked[i];
        ivec4 sides = sides_of(reached[cell] >> half_word);
        int pixels = max(sides.x + sides.y, sides.z + sides.w) - 1;
        uvec2 own = uvec2(cell % SIDE, cell / SIDE) - uvec2(TILE - BEGIN);
        if (float(pixels) >= params.shortest_line && max(own.x, own.y) < TILE) {
            atomicOr(stays[own.y], 1u << own.x);
        }
    }
}

// Share of the width that a line has on a step.
float narrowed(float high) {
    return 1.0 - params.outline_taper * (1.0 - clamp((high - LOWEST_STEP) / (FULL_STEP - LOWEST_STEP), 0.0, 1.0));
}

void main() {
    uvec2 tile = tile_at(occupied_tiles[gl_WorkGroupID.x]);
    uint lane = gl_LocalInvocationIndex;
    trace(tile, lane);
    if (lane < TILE) {
        stays[lane] = ALL_STAY != 0u ? ink[3u * (TILE + lane + 1u) + 1u] : 0u;
    }
    if (ALL_STAY == 0u && has_ink != 0u) {
        find_far_reaching(lane);
    }
    barrier();
    // Where there was no step is 0 already.
    const uint RUN = SLOT_PIXELS / LANES;
    uvec2 own = uvec2(lane * RUN % TILE, lane * RUN / TILE);
    uint weak = own_weak[own.y] >> own.x;
    uint bits = stays[own.y] >> own.x;
    for (uint i = 0u; i < RUN; ++i) {
        if ((weak >> i & 1u) != 0u) {
            uint at = pixel_index(tile * TILE + own + uvec2(i, 0u));
            float high = lines[at];
            float share = high == SILHOUETTE ? SILHOUETTE : narrowed(high);
            lines[at] = (bits >> i & 1u) != 0u ? share : 0.0;
        }
    }
}
