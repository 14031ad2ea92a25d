// Strength of the ink line of a frame at each of four samples a pixel, before its width.
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

uint name_at(ivec2 at) {
    return texelFetch(sampled, at, 0).x;
}

uint object_of(uint name) {
    return triangles[name - 1u].w >> OBJECT_SHIFT;
}

float depth_of_sample(ivec2 at) {
    return depth_of(texelFetch(sampled_depth, at, 0).x);
}

vec3 place_of_sample(ivec2 at) {
    return vec3(at, depth_of_sample(at));
}
#include "ink_line.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, 2 * ivec2(params.size)))) {
        return;
    }
    lines[index_of_sample(at)] = line_at(at);
}
