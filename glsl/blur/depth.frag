// The mesh's depth in the host's projection, where it covers all of a pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "picture.glsl"
#include "../common/host_depth.glsl"
#include "common/fragment.glsl"
layout(std430, binding = 1) readonly buffer Surface { Covering surface[]; };

void main() {
    Covering own = surface[index_of(ivec2(pixel_of(gl_FragCoord.xy, params.corner, params.size)))];
    if (isinf(own.depth) || isinf(own.behind)) {
        discard;
    }
    gl_FragDepth = host_depth(own.behind);
}
