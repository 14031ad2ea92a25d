// Strength of the ink line at each pixel, before its width (paper, section 3.5).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "tile.glsl"
#include "toon/ink.glsl"
#include "outline_depth.glsl"
#include "lines.glsl"
layout(std430, binding = 3) writeonly buffer Lines { float lines[]; };

float line_at(ivec2 at) {
    float centre = depth_at(at);
    if (centre == INFINITY) {
        return 0.0;
    }
    float a = depth_at(at + ivec2(-1, 1));
    float b = depth_at(at + ivec2(1, -1));
    float c = depth_at(at + ivec2(-1, -1));
    float d = depth_at(at + ivec2(1, 1));
    if (a == INFINITY || b == INFINITY || c == INFINITY || d == INFINITY) {
        return SILHOUETTE;
    }
    return ink_at(centre, vec4(a, b, c, d), per_unit_at(centre), params.inner_strength);
}

void work_on(uvec2 at) {
    lines[pixel_index(at)] = line_at(ivec2(at));
}
