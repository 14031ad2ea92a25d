// Replaces what is not frame i + 1's own.
layout(std430, binding = 1) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 3) readonly buffer Tiles { uint tiles[]; };
layout(location = 0) out vec4 colour;
#include "tiles.glsl"
#include "common/bits.glsl"
#include "common/fragment.glsl"

// The pixel's place in the picture.
uint replace() {
    uvec2 at = pixel_of(gl_FragCoord.xy, params.corner, params.size);
    uint index = index_of(ivec2(at));
    colour = picture[index];
    // Nothing has been made of a tile that is not worked on.
    bool is_made = tiles[flag_of((at.y / TILE) * params.tiles.x + at.x / TILE)] != 0u;
    if (!is_made || (floatBitsToUint(colour.a) & SIGN_BIT) != 0u) {
        discard;
    }
    return index;
}
