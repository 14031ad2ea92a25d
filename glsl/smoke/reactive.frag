// The share of each pixel that the smoke covers.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "screen.glsl"
#include "../common/host_depth.glsl"
#include "common/fragment.glsl"
layout(std430, binding = 2) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 3) readonly buffer Depth { float depth[]; };
layout(location = 0) out float share;

void main() {
    uint index = pixel_index(pixel_of(gl_FragCoord.xy, params.corner, params.size));
    share = picture[index].a;
    if (share == 0.0) {
        discard;
    }
    gl_FragDepth = host_depth(depth[index]);
}
