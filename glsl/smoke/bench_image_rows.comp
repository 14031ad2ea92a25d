// The exact separable form without skipping, rows: sums of one group over the whole image, tile by tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "gaussian.glsl"
layout(std430, binding = 3) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 4) writeonly buffer RowSums { vec2 row_sums[]; };
layout(push_constant) uniform ImageConstants { uint group; } constants;

void add_block(float w[2 * TAPS - 1], uint row, int first, uint group) {
    float values[TAPS];
    float masks[TAPS];
    for (int i = 0; i < TAPS; ++i) {
        int x = first + i;
        uint pixel = x < int(params.size.x) ? pixels[row + uint(x)] : 0u;
        masks[i] = pixel_id(pixel) == group ? 1.0 : 0.0;
        values[i] = masks[i] * pixel_luminance(pixel);
    }
    add_taps(w, values, masks);
}

void main() {
    uint tile = gl_WorkGroupID.x;
    uint block = gl_LocalInvocationID.y;
    uvec2 at = block_at(tile, block);
    int across = int(blocks_of_tiles().x);
    uint y = at.y * BLOCK + gl_LocalInvocationID.x;
    if (y >= params.size.y) {
        return;
    }
    clear_sums();
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int x = int(at.x) + side * distance;
            if (x >= 0 && x < across && (distance > 0 || side > 0)) {
                add_block(on_side(w, side), y * params.size.x, x * int(BLOCK), constants.group);
            }
        }
    }
    uint local = slot_row(block, gl_LocalInvocationID.x);
    for (uint o = 0u; o < BLOCK; ++o) {
        row_sums[tile * SLOT_PIXELS + local + o] = vec2(numerator[o], denominator[o]);
    }
}
