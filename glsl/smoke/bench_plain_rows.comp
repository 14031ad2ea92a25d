// The plain separable Gaussian over the whole image, rows.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench_plain.glsl"
layout(std430, binding = 3) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 4) writeonly buffer PlainRows { float plain_rows[]; };

void add_block(float w[2 * TAPS - 1], uint row, int first) {
    float values[TAPS];
    for (int i = 0; i < TAPS; ++i) {
        values[i] = pixel_luminance(pixels[row + uint(clamp(first + i, 0, int(params.size.x) - 1))]);
    }
    add_plain_taps(w, values);
}

void main() {
    uint tile = gl_WorkGroupID.x;
    uint block = gl_LocalInvocationID.y;
    uvec2 at = block_at(tile, block);
    uint y = at.y * BLOCK + gl_LocalInvocationID.x;
    if (y >= params.size.y) {
        return;
    }
    for (int o = 0; o < TAPS; ++o) {
        sums[o] = 0.0;
    }
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = distance > 0 ? -1 : 1; side <= 1; side += 2) {
            add_block(on_side(w, side), y * params.size.x, (int(at.x) + side * distance) * int(BLOCK));
        }
    }
    uint local = slot_row(block, gl_LocalInvocationID.x);
    for (uint o = 0u; o < BLOCK; ++o) {
        plain_rows[tile * SLOT_PIXELS + local + o] = sums[o] * SCALE;
    }
}
