// As `background`, of a frame that has been drawn: over what the target has, where the host has drawn nothing nearer.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "picture.glsl"
#include "../common/host_depth.glsl"
#include "common/fragment.glsl"
layout(binding = 1) uniform texture2D drawn;
layout(std430, binding = 2) readonly buffer Surface { Covering surface[]; };
layout(location = 0) out vec4 colour;

void main() {
    ivec2 pixel = ivec2(pixel_of(gl_FragCoord.xy, params.corner, params.size));
    Covering own = surface[index_of(pixel)];
    if (isinf(own.depth)) {
        discard;
    }
    colour = texelFetch(drawn, pixel, 0);
    gl_FragDepth = host_depth(isinf(own.behind) ? own.depth : own.behind);
}
