// The mesh's depth in the host's projection, where it hides what is behind it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/host_depth.glsl"
layout(std430, binding = 1) readonly buffer Surface { float surface[]; };

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    float depth = surface[at.y * params.image.x + at.x];
    if (isinf(depth)) {
        discard;
    }
    gl_FragDepth = host_depth(depth);
}
