// The exact separable form without skipping, rows: sums of one group over the whole image, tile by tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "pixel.glsl"
#include "gaussian.glsl"
layout(std430, binding = 3) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 4) writeonly buffer RowSums { vec2 row_sums[]; };

void add_block(int block, uint row, int first, uint group) {
    float values[8];
    float masks[8];
    for (int i = 0; i < 8; ++i) {
        int x = first + i;
        uint pixel = x < int(params.size.x) ? pixels[row + uint(x)] : 0u;
        masks[i] = pixel_id(pixel) == group ? 1.0 : 0.0;
        values[i] = masks[i] * pixel_luminance(pixel);
    }
    add_taps(block, values, masks);
}

void main() {
    uint tile = gl_WorkGroupID.x;
    uint block = gl_LocalInvocationID.y;
    uvec2 at = uvec2(tile % params.tiles.x, tile / params.tiles.x) * TILE_BLOCKS
        + uvec2(block % TILE_BLOCKS, block / TILE_BLOCKS);
    int across = int(params.tiles.x * TILE_BLOCKS);
    uint y = at.y * BLOCK + gl_LocalInvocationID.x;
    if (y >= params.size.y) {
        return;
    }
    for (int o = 0; o < 8; ++o) {
        numerator[o] = 0.0;
        denominator[o] = 0.0;
    }
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        for (int side = -1; side <= 1; side += 2) {
            int x = int(at.x) + side * distance;
            if (x >= 0 && x < across && (distance > 0 || side > 0)) {
                add_block(side * distance, y * params.size.x, x * int(BLOCK), constants.first_group);
            }
        }
    }
    uint local = (block / TILE_BLOCKS * BLOCK + gl_LocalInvocationID.x) * TILE + block % TILE_BLOCKS * BLOCK;
    for (uint o = 0u; o < 8u; ++o) {
        row_sums[tile * SLOT_PIXELS + local + o] = vec2(numerator[o], denominator[o]);
    }
}
