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

void main() {
    uvec2 at = pixel_of(gl_FragCoord.xy, params.corner, params.size);
    uint index = pixel_index(at);
    colour = picture[index];
    if (colour.a == 0.0) {
        discard;
    }
    if (constants.has_edges != 0u && depth[index] > edges[index].depth) {
        vec4 before = colour_of(edges[index]);
        colour = before + (1.0 - before.a) * colour;
    }
    gl_FragDepth = host_depth(depth[index]);
}
