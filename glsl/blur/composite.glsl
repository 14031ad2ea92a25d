// Replaces what is not frame i + 1's own.
layout(std430, binding = 1) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 3) readonly buffer Tiles { uint tiles[]; };
layout(location = 0) out vec4 colour;
#include "tiles.glsl"

// The pixel's place in the picture.
uint replace() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint index = at.y * params.size.x + at.x;
    colour = picture[index];
    // Nothing has been made of a tile that is not worked on.
    bool is_made = tiles[flag_of((at.y / 8u) * params.tiles.x + at.x / 8u)] != 0u;
    if (!is_made || floatBitsToUint(colour.a) >> 31u != 0u) {
        discard;
    }
    return index;
}
