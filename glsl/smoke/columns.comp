// Column sums over the row sums of one (tile, group), and the quotient for the pixels of that group.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "gaussian.glsl"
layout(std430, binding = 3) readonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 4) readonly buffer ColumnItems { uint column_items[]; };
layout(std430, binding = 5) readonly buffer RowSlots { uint row_slots[]; };
layout(std430, binding = 6) readonly buffer RowSums { vec2 row_sums[]; };
layout(std430, binding = 7) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 8) writeonly buffer Smooth { float smooth_luminance[]; };

void add_block(int block, uint first, uint rows) {
    float values[TAPS];
    float masks[TAPS];
    for (uint i = 0u; i < BLOCK; ++i) {
        vec2 sums = i < rows ? row_sums[first + i * TILE] : vec2(0.0);
        values[i] = sums.x;
        masks[i] = sums.y;
    }
    add_taps(block, values, masks);
}

void main() {
    uint item = column_items[constants.base + gl_WorkGroupID.x];
    uint group = item & GROUP_MASK;
    uint tile = item >> GROUP_BITS;
    uint block = gl_LocalInvocationID.y;
    uint tile_x = tile_at(tile).x;
    uvec2 at = block_at(tile, block);
    uint across = blocks_of_tiles().x;
    uint down = blocks_of_tiles().y;
    uint bit = group_bit(group);
    uint x = at.x * BLOCK + gl_LocalInvocationID.x;
    if ((block_masks[at.y * across + at.x] & bit) == 0u || x >= params.size.x) {
        return;
    }
    clear_sums();
    uint slots = constants.base + (group - constants.first_group) * params.tiles.x * params.tiles.y;
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        for (int side = -1; side <= 1; side += 2) {
            int y = int(at.y) + side * distance;
            bool used = y >= 0 && y < int(down) && (distance > 0 || side > 0);
            if (used && (reached[uint(y) * across + at.x].beside & bit) != 0u) {
                uint slot = row_slots[slots + uint(y) / TILE_BLOCKS * params.tiles.x + tile_x];
                uint local = uint(y) % TILE_BLOCKS * BLOCK * TILE + x % TILE;
                uint rows = min(BLOCK, params.size.y - min(uint(y) * BLOCK, params.size.y));
                add_block(side * distance, slot * SLOT_PIXELS + local, rows);
            }
        }
    }
    for (uint o = 0u; o < BLOCK; ++o) {
        uint y = at.y * BLOCK + o;
        if (y < params.size.y && pixel_id(pixels[pixel_index(uvec2(x, y))]) == group) {
            smooth_luminance[pixel_index(uvec2(x, y))] = numerator[o] / denominator[o];
        }
    }
}
