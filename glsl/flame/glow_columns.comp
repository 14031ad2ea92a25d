// Column sums over the row sums of glow, added to the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 2) readonly buffer TileShown { uint tile_shown[]; };
layout(std430, binding = 3) buffer Picture { vec4 picture[]; };
layout(std430, binding = 4) readonly buffer GlowWeights { float weights[]; };
layout(std430, binding = 5) readonly buffer GlowSums { vec4 glow_sums[]; };
#include "glow.glsl"

void main() {
    uvec2 tile = tile_at(occupied_tiles[gl_WorkGroupID.x]);
    uint x = tile.x * TILE + gl_LocalInvocationID.x % TILE;
    int first = int(tile.y * TILE + gl_LocalInvocationID.x / TILE * uint(TAPS));
    if (x >= params.size.x) {
        return;
    }
    clear_glow();
    for (int distance = glow_blocks(); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int row = first + side * distance * TAPS;
            bool is_used = row >= 0 && row < int(params.tiles.y * TILE) && (distance > 0 || side > 0);
            if (is_used && tile_shown[uint(row) / TILE * params.tiles.x + tile.x] != 0u) {
                vec3 light[TAPS];
                for (int t = 0; t < TAPS; ++t) {
                    uint y = uint(row + t);
                    light[t] = vec3(0.0);
                    if (y < params.size.y) {
                        light[t] = glow_sums[y * params.size.x + x].rgb;
                    }
                }
                add_light(on_side(w, side), light);
            }
        }
    }
    for (int o = 0; o < TAPS; ++o) {
        uint y = uint(first + o);
        if (y < params.size.y) {
            picture[y * params.size.x + x].rgb += params.glow * glow[o];
        }
    }
}
