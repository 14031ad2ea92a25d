// Strength of the ink line at each pixel, before its width: 1 - l with l = max(0, 1 - w l') (paper, section 3.5), from
// view depth in units of max(smallest voxel side, eight pixel footprints).
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const uint SECOND = 0u;  // 1: second differences
#include "params.glsl"
#include "tile.glsl"
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
    float per_unit = 1.0 / max(params.smallest_side, 8.0 * params.pixel_footprint * centre);
    float first = SECOND != 0u ? (a - centre) + (b - centre) : a - b;
    float second = SECOND != 0u ? (c - centre) + (d - centre) : c - d;
    first *= per_unit;
    second *= per_unit;
    return 1.0 - max(0.0, 1.0 - params.outline_strength * (first * first + second * second));
}

void work_on(uvec2 at) {
    lines[pixel_index(at)] = line_at(ivec2(at));
}
