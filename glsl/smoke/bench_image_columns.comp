// The exact separable form without skipping, columns: over the row sums of one group, for the whole image.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "pixel.glsl"
#include "gaussian.glsl"
layout(std430, binding = 3) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 4) readonly buffer RowSums { vec2 row_sums[]; };
layout(std430, binding = 5) writeonly buffer Smooth { float smooth_luminance[]; };

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
    uint tile = gl_WorkGroupID.x;
    uint block = gl_LocalInvocationID.y;
    uvec2 tile_at = uvec2(tile % params.tiles.x, tile / params.tiles.x);
    uvec2 at = tile_at * TILE_BLOCKS + uvec2(block % TILE_BLOCKS, block / TILE_BLOCKS);
    int down = int(params.tiles.y * TILE_BLOCKS);
    uint x = at.x * BLOCK + gl_LocalInvocationID.x;
    if (x >= params.size.x) {
        return;
    }
    for (int o = 0; o < 8; ++o) {
        numerator[o] = 0.0;
        denominator[o] = 0.0;
    }
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        for (int side = -1; side <= 1; side += 2) {
            int y = int(at.y) + side * distance;
            if (y >= 0 && y < down && (distance > 0 || side > 0)) {
                uint slot = uint(y) / TILE_BLOCKS * params.tiles.x + tile_at.x;
                uint local = uint(y) % TILE_BLOCKS * BLOCK * TILE + x % TILE;
                uint rows = min(BLOCK, params.size.y - min(uint(y) * BLOCK, params.size.y));
                add_block(side * distance, slot * SLOT_PIXELS + local, rows);
            }
        }
    }
    for (uint o = 0u; o < 8u; ++o) {
        uint y = at.y * BLOCK + o;
        if (y < params.size.y && pixel_id(pixels[y * params.size.x + x]) == constants.first_group) {
            smooth_luminance[y * params.size.x + x] = numerator[o] / denominator[o];
        }
    }
}
