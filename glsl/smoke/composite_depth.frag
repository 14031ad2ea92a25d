// As `composite`, at the smoke's depth in the host's projection: what the host has drawn nearer stays in front, and what
// covers a pixel in part stays over the smoke.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "screen.glsl"
#include "edges.glsl"
#include "../common/host_depth.glsl"
#include "common/fragment.glsl"

layout(push_constant) uniform CompositeConstants {
    uint has_edges;
} constants;
layout(std430, binding = 2) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 3) readonly buffer Depth { float depth[]; };
layout(std430, binding = 4) readonly buffer Edges { Edge edges[]; };
layout(location = 0) out vec4 colour;

// Of a pixel that smoke covers only in part: that of the nearest pixel beside it.
float nearest_beside(uvec2 at) {
    float nearest = INFINITY;
    for (uint i = 0u; i < 9u; ++i) {
        uvec2 beside = at + uvec2(i % 3u, i / 3u) - 1u;
        nearest = is_in_picture(beside) ? min(nearest, depth[pixel_index(beside)]) : nearest;
    }
    return nearest;
}

void main() {
    uvec2 at = pixel_of(gl_FragCoord.xy, params.corner, params.size);
    uint index = pixel_index(at);
    colour = picture[index];
    if (colour.a == 0.0) {
        discard;
    }
    float z = depth[index] < INFINITY ? depth[index] : nearest_beside(at);
    if (constants.has_edges != 0u && z > edges[index].depth) {
        vec4 before = colour_of(edges[index]);
        colour = before + (1.0 - before.a) * colour;
    }
    gl_FragDepth = host_depth(z);
}
