// k, l and k' of the mesh's points.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Motions { vec4 motions[]; };
layout(std430, binding = 2) readonly buffer Labels { uint labels[]; };
layout(std430, binding = 3) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 4) readonly buffer Hull { vec2 hull[]; };
layout(std430, binding = 5) writeonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 6) writeonly buffer Smooth { uint smooth_values[]; };
// Each invocation looks at one hull once.
#define MOST_SCANNED 700000u
#include "extent.glsl"

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.counts.x) {
        return;
    }
    vec4 motion = motions[point];
    uint label = labels[point];
    vec2 extent = extent_of(motion, label);
    float moved = moved_by(extent, label);
    vertices[point] = Vertex(motion, vec4(extent, 0.0, moved), vec4(0.0), uvec4(label, 1u, 0u, 0u));
    uint whole = whole_of(moved);
    smooth_values[point] = whole;
    smooth_values[params.counts.x + point] = whole;
}
