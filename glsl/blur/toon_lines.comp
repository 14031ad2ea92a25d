// Strength of the ink line at each of four samples a pixel, before its width, from differences of depth in units of eight
// samples' footprints. A line is also where another object or nothing is beside a sample.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "picture.glsl"
#include "depths.glsl"
#include "toon.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
layout(binding = 1) uniform utexture2D sampled;
layout(binding = 2) uniform texture2D sampled_depth;
layout(std430, binding = 3) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 5) writeonly buffer Lines { float lines[]; };
#include "toon/ink.glsl"

ivec2 inside(ivec2 at) {
    return clamp(at, ivec2(0), 2 * ivec2(params.size) - 1);
}

float depth_at(ivec2 at) {
    return depth_of(texelFetch(sampled_depth, at, 0).x);
}

float line_at(ivec2 at) {
    uint own = texelFetch(sampled, at, 0).x;
    if (own == 0u) {
        return 0.0;
    }
    float centre = depth_at(at);
    vec4 beside;
    for (int i = 0; i < 4; ++i) {
        ivec2 there = inside(at + ivec2(i == 1 || i == 3 ? 1 : -1, i == 0 || i == 3 ? 1 : -1));
        uint other = texelFetch(sampled, there, 0).x;
        if (other == 0u || triangles[other - 1u].w >> OBJECT_SHIFT != triangles[own - 1u].w >> OBJECT_SHIFT) {
            return 1.0;
        }
        beside[i] = depth_at(there);
    }
    float per_unit = 1.0 / (8.0 * toon.sample_extent * widening(centre));
    return ink_at(centre, beside, per_unit, toon.ink_strength);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, 2 * ivec2(params.size)))) {
        return;
    }
    lines[index_of_sample(at)] = line_at(at);
}
