// Column sums over the row sums of one (tile, group), and the quotient for the pixels of that group.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "pixel.glsl"
#include "gaussian.glsl"
layout(std430, binding = 3) readonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 4) readonly buffer ColumnItems { uint column_items[]; };
layout(std430, binding = 5) readonly buffer RowSlots { uint row_slots[]; };
layout(std430, binding = 6) readonly buffer RowSums { vec2 row_sums[]; };
layout(std430, binding = 7) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 8) writeonly buffer Smooth { float smooth_luminance[]; };

void add_block(int block, uint first, uint rows) {
    float values[8];
    float masks[8];
    for (uint i = 0u; i < 8u; ++i) {
        vec2 sums = i < rows ? row_sums[first + i * TILE] : vec2(0.0);
        values[i] = sums.x;
        masks[i] = sums.y;
    }
    add_taps(block, values, masks);
}

void main() {
    uint item = column_items[constants.base + gl_WorkGroupID.x];
    uint group = item & 255u;
    uint tile = item >> 8;
    uint block = gl_LocalInvocationID.y;
    uvec2 tile_at = uvec2(tile % params.image.z, tile / params.image.z);
    uvec2 at = tile_at * TILE_BLOCKS + uvec2(block % TILE_BLOCKS, block / TILE_BLOCKS);
    uint across = params.image.z * TILE_BLOCKS;
    uint down = params.image.w * TILE_BLOCKS;
    uint bit = 1u << (group & 31u);
    uint x = at.x * BLOCK + gl_LocalInvocationID.x;
    if ((block_masks[at.y * across + at.x] & bit) == 0u || x >= params.image.x) {
        return;
    }
    for (int o = 0; o < 8; ++o) {
        numerator[o] = 0.0;
        denominator[o] = 0.0;
    }
    uint slots = constants.base + (group - constants.first_group) * params.image.z * params.image.w;
    for (int distance = int(params.filtering.y); distance >= 0; --distance) {
        for (int side = -1; side <= 1; side += 2) {
            int y = int(at.y) + side * distance;
            bool used = y >= 0 && y < int(down) && (distance > 0 || side > 0);
            if (used && (reached[uint(y) * across + at.x].x & bit) != 0u) {
                uint slot = row_slots[slots + uint(y) / TILE_BLOCKS * params.image.z + tile_at.x];
                uint local = uint(y) % TILE_BLOCKS * BLOCK * TILE + x % TILE;
                uint rows = min(BLOCK, params.image.y - min(uint(y) * BLOCK, params.image.y));
                add_block(side * distance, slot * SLOT_PIXELS + local, rows);
            }
        }
    }
    for (uint o = 0u; o < 8u; ++o) {
        uint y = at.y * BLOCK + o;
        if (y < params.image.y && pixel_id(pixels[y * params.image.x + x]) == group) {
            smooth_luminance[y * params.image.x + x] = numerator[o] / denominator[o];
        }
    }
}
