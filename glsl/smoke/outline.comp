// Strength of the ink line at each pixel, before its width (paper, section 3.5), from view depth in
// units of max(smallest voxel side, eight pixel footprints).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "tile.glsl"
#include "toon/ink.glsl"
#include "common/widening.glsl"
layout(std430, binding = 2) readonly buffer Depth { float depth[]; };
layout(std430, binding = 3) writeonly buffer Lines { float lines[]; };

float depth_at(ivec2 at) {
    return depth[pixel_index(uvec2(clamp(at, ivec2(0), ivec2(params.size) - 1)))];
}

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
        return 1.0;
    }
    float per_unit = 1.0 / max(params.smallest_side, 8.0 * params.pixel_footprint * widening(centre));
    return ink_at(centre, vec4(a, b, c, d), per_unit, params.outline_strength);
}

void work_on(uvec2 at) {
    lines[pixel_index(at)] = line_at(ivec2(at));
}
