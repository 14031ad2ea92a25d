// The share of each pixel that the fire covers.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "common/fragment.glsl"
layout(std430, binding = 2) readonly buffer Picture { vec4 picture[]; };
layout(location = 0) out float share;

void main() {
    share = picture[pixel_index(pixel_of(gl_FragCoord.xy, params.corner, params.size))].a;
    if (share == 0.0) {
        discard;
    }
}
