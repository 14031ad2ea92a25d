// What the mesh covers image i + 1 with, where that is the output.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
layout(binding = 1) uniform texture2D sampled_depth;
layout(binding = 2) uniform texture2D frame_next;
layout(std430, binding = 3) writeonly buffer Picture { vec4 picture[]; };
layout(binding = 4) uniform texture2D background_image;
#include "under.glsl"
layout(constant_id = 0) const uint LAYERS = 0;  // 1: layers are kept
#include "surface.glsl"

float nearness_at(ivec2 at) {
    return texelFetch(sampled_depth, at, 0).x;
}

vec4 next_at(ivec2 pixel) {
    return texelFetch(frame_next, pixel, 0);
}

bool is_beside(ivec2 pixel) {
    return is_empty(pixel);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(params.size)))) {
        return;
    }
    vec4 seen;
    for (int i = 0; i < 4; ++i) {
        seen[i] = nearness_at(sample_of(pixel, i));
    }
    float nearest = max(max(seen.x, seen.y), max(seen.z, seen.w));
    float covered = dot(vec4(greaterThan(seen, vec4(0.0))), vec4(0.25));
    float front = dot(front_of(seen, nearest), vec4(0.25));
    vec4 colour = nearest > 0.0 ? front / covered * part_of_next(pixel, covered) : vec4(0.0);
    uint index = index_of(pixel);
    covers(index, colour, nearest, depth_of(min(min(seen.x, seen.y), min(seen.z, seen.w))));
    if (LAYERS == 1u) {
        picture[index] = over_background(next_at(pixel), pixel);
    }
}
