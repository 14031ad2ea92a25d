// The mesh's depth in the host's projection, where it covers all of a pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/host_depth.glsl"
layout(push_constant) uniform HostDepthConstants { vec2 terms; } constants;
layout(std430, binding = 1) readonly buffer Surface { uvec4 surface[]; };

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uvec4 own = surface[at.y * params.image.x + at.x];
    float behind = uintBitsToFloat(own.w);
    if (isinf(uintBitsToFloat(own.z)) || isinf(behind)) {
        discard;
    }
    gl_FragDepth = host_depth(constants.terms, behind);
}
