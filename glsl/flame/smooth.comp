// Row sums of heat under a Gaussian, and, before a scene, of the weights of what that does not hide. Tiles without fire add
// nothing to the first.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 2) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 3) readonly buffer TileShown { uint tile_shown[]; };
layout(std430, binding = 4) readonly buffer TileRepetitions { uint tile_repetitions[]; };
layout(std430, binding = 5) readonly buffer Sums { uvec4 sums[]; };
layout(std430, binding = 6) readonly buffer Scene { float scene[]; };
layout(std430, binding = 7) readonly buffer Weights { float weights[]; };
layout(std430, binding = 8) writeonly buffer RowSums { vec2 row_sums[]; };
#include "heat.glsl"
#define TAPS 4
#include "toon/gaussian.glsl"

float heat[TAPS];
float seen[TAPS];

// Adds the taps from column `first` on, which are all of one tile.
void add_block(float w[2 * TAPS - 1], uint row, uint first, bool has_fire, float n, float brightest) {
    float values[TAPS];
    float masks[TAPS];
    for (uint t = 0u; t < uint(TAPS); ++t) {
        bool is_inside = first + t < params.size.x;
        uint at = row + min(first + t, params.size.x - 1u);
        values[t] = 0.0;
        masks[t] = 0.0;
        if (is_inside && has_fire) {
            values[t] = heat_at(at, n, brightest);
        }
        if (HAS_SCENE == 1u) {
            if (is_inside && !is_hidden(at, has_fire)) {
                masks[t] = 1.0;
            }
        }
    }
    add_values(heat, w, values);
    if (HAS_SCENE == 1u) {
        add_values(seen, w, masks);
    }
}

void main() {
    const uint BLOCKS_ACROSS = TILE / uint(TAPS);
    uvec2 tile = tile_at(occupied_tiles[gl_WorkGroupID.x]);
    uint own = tile.x * BLOCKS_ACROSS + gl_LocalInvocationID.x % BLOCKS_ACROSS;
    uint y = tile.y * TILE + gl_LocalInvocationID.x / BLOCKS_ACROSS;
    if (y >= params.size.y) {
        return;
    }
    float brightest = uintBitsToFloat(control.brightest);
    int end = int(params.tiles.x * BLOCKS_ACROSS);
    for (int o = 0; o < TAPS; ++o) {
        heat[o] = 0.0;
        seen[o] = 0.0;
    }
    for (int distance = (params.window + TAPS - 1 + TAPS - 1) / TAPS; distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int x = int(own) + side * distance;
            if (x >= 0 && x < end && (distance > 0 || side > 0)) {
                uint other = tile.y * params.tiles.x + uint(x) / BLOCKS_ACROSS;
                bool has_fire = (tile_shown[other] & BURNING) != 0u;
                if (has_fire || HAS_SCENE == 1u) {
                    float n = has_fire && EXPECTED == 0u ? float(tile_repetitions[other]) : 0.0;
                    uint row = y * params.size.x;
                    add_block(on_side(w, side), row, uint(x) * uint(TAPS), has_fire, n, brightest);
                }
            }
        }
    }
    for (uint o = 0u; o < uint(TAPS); ++o) {
        uint x = own * uint(TAPS) + o;
        if (x < params.size.x) {
            row_sums[y * params.size.x + x] = vec2(heat[o], seen[o]);
        }
    }
}
