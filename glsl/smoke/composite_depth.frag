// As `composite`, at the smoke's depth in the host's projection: what the host has drawn nearer stays in front.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/host_depth.glsl"
layout(std430, binding = 2) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 3) readonly buffer Depth { float depth[]; };
layout(location = 0) out vec4 colour;

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint index = at.y * params.image.x + at.x;
    colour = picture[index];
    if (colour.a == 0.0) {
        discard;
    }
    gl_FragDepth = host_depth(depth[index]);
}
