// As `composite`, where the host has drawn nothing nearer.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/host_depth.glsl"
#include "composite.glsl"
layout(std430, binding = 2) readonly buffer Surface { Covering surface[]; };

void main() {
    uint index = replace();
    Covering own = surface[index];
    gl_FragDepth = host_depth(isinf(own.behind) ? own.depth : own.behind);
}
