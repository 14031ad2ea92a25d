// Replaces what is not frame i + 1's own.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 1) readonly buffer Picture { vec4 picture[]; };
layout(location = 0) out vec4 colour;

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    colour = picture[at.y * params.image.x + at.x];
    if (colour.a < 0.0) {
        discard;
    }
}
