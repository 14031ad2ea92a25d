// The plain separable Gaussian over the whole image, columns.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench_plain.glsl"
layout(std430, binding = 3) readonly buffer PlainRows { float plain_rows[]; };
layout(std430, binding = 4) writeonly buffer Smooth { float smooth_luminance[]; };

void add_block(float w[2 * TAPS - 1], uint tile_x, uint x, int first) {
    float values[TAPS];
    for (int i = 0; i < TAPS; ++i) {
        uint y = uint(clamp(first + i, 0, int(params.size.y) - 1));
        uint slot = y / TILE * params.tiles.x + tile_x;
        values[i] = plain_rows[slot * SLOT_PIXELS + y % TILE * TILE + x % TILE];
    }
    add_plain_taps(w, values);
}

void main() {
    uint tile = gl_WorkGroupID.x;
    uint block = gl_LocalInvocationID.y;
    uint tile_x = tile_at(tile).x;
    uvec2 at = block_at(tile, block);
    uint x = at.x * BLOCK + gl_LocalInvocationID.x;
    if (x >= params.size.x) {
        return;
    }
    for (int o = 0; o < TAPS; ++o) {
        sums[o] = 0.0;
    }
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = distance > 0 ? -1 : 1; side <= 1; side += 2) {
            add_block(on_side(w, side), tile_x, x, (int(at.y) + side * distance) * int(BLOCK));
        }
    }
    for (uint o = 0u; o < BLOCK; ++o) {
        uint y = at.y * BLOCK + o;
        if (y < params.size.y) {
            smooth_luminance[pixel_index(uvec2(x, y))] = sums[o] * SCALE;
        }
    }
}
