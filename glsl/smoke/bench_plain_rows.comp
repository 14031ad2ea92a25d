// The plain separable Gaussian over the whole image, rows.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench_plain.glsl"
layout(std430, binding = 3) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 4) writeonly buffer PlainRows { float plain_rows[]; };

void add_block(int block, uint row, int first) {
    float values[8];
    for (int i = 0; i < 8; ++i) {
        values[i] = pixel_luminance(pixels[row + uint(clamp(first + i, 0, int(params.size.x) - 1))]);
    }
    add_plain_taps(block, values);
}

void main() {
    uint tile = gl_WorkGroupID.x;
    uint block = gl_LocalInvocationID.y;
    uvec2 at = uvec2(tile % params.tiles.x, tile / params.tiles.x) * TILE_BLOCKS
        + uvec2(block % TILE_BLOCKS, block / TILE_BLOCKS);
    uint y = at.y * BLOCK + gl_LocalInvocationID.x;
    if (y >= params.size.y) {
        return;
    }
    for (int o = 0; o < 8; ++o) {
        sums[o] = 0.0;
    }
    int window = int(params.window_blocks);
    for (int distance = -window; distance <= window; ++distance) {
        add_block(distance, y * params.size.x, (int(at.x) + distance) * int(BLOCK));
    }
    uint local = (block / TILE_BLOCKS * BLOCK + gl_LocalInvocationID.x) * TILE + block % TILE_BLOCKS * BLOCK;
    for (uint o = 0u; o < 8u; ++o) {
        plain_rows[tile * SLOT_PIXELS + local + o] = sums[o] * SCALE;
    }
}
