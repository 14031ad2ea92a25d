// Black over the target.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "common/fragment.glsl"

layout(std430, binding = 1) readonly buffer Darkness { float darkness[]; };
layout(location = 0) out vec4 colour;

void main() {
    uvec2 pixel = pixel_of(gl_FragCoord.xy, corner, size);
    colour = vec4(0.0, 0.0, 0.0, darkness[pixel.y * size.x + pixel.x]);
}
