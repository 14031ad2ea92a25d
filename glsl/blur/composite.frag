// Replaces what is not frame i + 1's own.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 1) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 2) readonly buffer Tiles { uint tiles[]; };
layout(location = 0) out vec4 colour;
#include "tiles.glsl"

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    colour = picture[at.y * params.image.x + at.x];
    if (tiles[flag_of((at.y / 8u) * tiles_across() + at.x / 8u)] == 0u || colour.a < 0.0) {
        discard;
    }
}
