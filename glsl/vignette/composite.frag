// Black over the target.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"

layout(std430, binding = 1) readonly buffer Darkness { float darkness[]; };
layout(location = 0) out vec4 colour;

void main() {
    uvec2 pixel = uvec2(gl_FragCoord.xy) - corner;
    colour = vec4(0.0, 0.0, 0.0, darkness[pixel.y * size.x + pixel.x]);
}
