// The exact separable form without skipping, columns: over the row sums of one group, for the whole image.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "gaussian.glsl"
layout(std430, binding = 3) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 4) readonly buffer RowSums { vec2 row_sums[]; };
layout(std430, binding = 5) writeonly buffer Smooth { float smooth_luminance[]; };
layout(push_constant) uniform ImageConstants { uint group; } constants;

void add_block(float w[2 * TAPS - 1], uint first, uint rows) {
    float values[TAPS];
    float masks[TAPS];
    for (uint i = 0u; i < BLOCK; ++i) {
        vec2 sums = i < rows ? row_sums[first + i * TILE] : vec2(0.0);
        values[i] = sums.x;
        masks[i] = sums.y;
    }
    add_taps(w, values, masks);
}

void main() {
    uint tile = gl_WorkGroupID.x;
    uint block = gl_LocalInvocationID.y;
    uint tile_x = tile_at(tile).x;
    uvec2 at = block_at(tile, block);
    int down = int(blocks_of_tiles().y);
    uint x = at.x * BLOCK + gl_LocalInvocationID.x;
    if (x >= params.size.x) {
        return;
    }
    clear_sums();
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int y = int(at.y) + side * distance;
            if (y >= 0 && y < down && (distance > 0 || side > 0)) {
                uint slot = uint(y) / TILE_BLOCKS * params.tiles.x + tile_x;
                uint local = uint(y) % TILE_BLOCKS * BLOCK * TILE + x % TILE;
                uint rows = min(BLOCK, params.size.y - min(uint(y) * BLOCK, params.size.y));
                add_block(on_side(w, side), slot * SLOT_PIXELS + local, rows);
            }
        }
    }
    for (uint o = 0u; o < BLOCK; ++o) {
        uint y = at.y * BLOCK + o;
        if (y < params.size.y && pixel_id(pixels[pixel_index(uvec2(x, y))]) == constants.group) {
            smooth_luminance[pixel_index(uvec2(x, y))] = numerator[o] / denominator[o];
        }
    }
}
