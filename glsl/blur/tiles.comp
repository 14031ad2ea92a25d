// Which tiles of the picture have anything of the mesh in or near them: in frame i, in frame i + 1, or as it is drawn. What
// makes the picture works on these alone.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
layout(binding = 1) uniform utexture2D seen_previous;
layout(binding = 2) uniform utexture2D seen_next;
layout(binding = 3) uniform utexture2D sampled;
layout(std430, binding = 4) buffer Tiles { uint tiles[]; };
#include "tiles.glsl"

shared uint seen;

// Lists a tile once, and makes the dispatches large enough for it.
void list(uint tile) {
    if (atomicExchange(tiles[flag_of(tile)], 1u) != 0u) {
        return;
    }
    uint place = atomicAdd(tiles[0], 1u);
    tiles[place_of(place)] = tile;
    for (uint i = 0u; i < DISPATCHES; ++i) {
        atomicMax(tiles[TILE_DISPATCHES + 4u * i], min(place, ROW - 1u) + 1u);
        atomicMax(tiles[TILE_DISPATCHES + 4u * i + 1u], place / ROW + 1u);
    }
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (gl_LocalInvocationIndex == 0u) {
        seen = params.is_whole;
    }
    barrier();
    if (all(lessThan(at, ivec2(params.size)))) {
        uint any_of = texelFetch(seen_previous, at, 0).x | texelFetch(seen_next, at, 0).x;
        for (int i = 0; i < 4; ++i) {
            any_of |= texelFetch(sampled, sample_of(at, i), 0).x;
        }
        if (any_of != 0u) {
            atomicOr(seen, 1u);
        }
    }
    barrier();
    // What lies around the mesh in images reaches as far as the skirt, and borders read what is beside them.
    int reach = (int(ceil(params.skirt)) + int(TILE)) / int(TILE);
    int side = 2 * reach + 1;
    ivec2 size = ivec2(params.tiles);
    for (int i = int(gl_LocalInvocationIndex); i < (seen != 0u ? side * side : 0); i += int(TILE * TILE)) {
        ivec2 other = ivec2(gl_WorkGroupID.xy) + ivec2(i % side, i / side) - reach;
        if (all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, size))) {
            list(uint(other.y * size.x + other.x));
        }
    }
}
