// Row sums of the light of the picture that is above 1. Only tiles with tones or sprites have any.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 2) readonly buffer TileShown { uint tile_shown[]; };
layout(std430, binding = 3) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 4) readonly buffer GlowWeights { float weights[]; };
layout(std430, binding = 5) writeonly buffer GlowSums { vec4 glow_sums[]; };
#include "glow.glsl"

void main() {
    const uint BLOCKS_ACROSS = TILE / uint(TAPS);
    uvec2 tile = tile_at(occupied_tiles[gl_WorkGroupID.x]);
    int own = int(tile.x * BLOCKS_ACROSS + gl_LocalInvocationID.x % BLOCKS_ACROSS);
    uint y = tile.y * TILE + gl_LocalInvocationID.x / BLOCKS_ACROSS;
    if (y >= params.size.y) {
        return;
    }
    int end = int(params.tiles.x * BLOCKS_ACROSS);
    clear_glow();
    for (int distance = glow_blocks(); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int x = own + side * distance;
            bool is_used = x >= 0 && x < end && (distance > 0 || side > 0);
            if (is_used && tile_shown[tile.y * params.tiles.x + uint(x) / BLOCKS_ACROSS] != 0u) {
                vec3 light[TAPS];
                for (int t = 0; t < TAPS; ++t) {
                    uint column = uint(x * TAPS + t);
                    light[t] = vec3(0.0);
                    if (column < params.size.x) {
                        light[t] = max(picture[y * params.size.x + column].rgb - 1.0, 0.0);
                    }
                }
                add_light(on_side(w, side), light);
            }
        }
    }
    for (int o = 0; o < TAPS; ++o) {
        uint x = uint(own * TAPS + o);
        if (x < params.size.x) {
            glow_sums[y * params.size.x + x] = vec4(glow[o], 0.0);
        }
    }
}
