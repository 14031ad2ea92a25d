// k, l and k' of the mesh's points.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Motions { PointMotion motions[]; };
layout(std430, binding = 2) readonly buffer Labels { uint labels[]; };
layout(std430, binding = 3) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 4) readonly buffer Bounds { vec2 bounds[]; };
layout(std430, binding = 5) writeonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 6) writeonly buffer Smooth { uint smooth_values[]; };
layout(std430, binding = 7) readonly buffer Shares { float shares[]; };
// Each invocation looks at one hull once.
#define MOST_SCANNED 700000u
#include "extent.glsl"

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.points) {
        return;
    }
    PointMotion motion = motions[point];
    uint label = labels[point];
    vec2 extent = extent_of(motion.position, motion.velocity, label);
    float share = shares[point] * share_at(motion.velocity);
    float moved = moved_by(extent, label, share);
    vertices[point] = Vertex(motion.position, motion.velocity, extent.x, extent.y, 0.0, moved, vec2(0.0), 0.0, 0.0, label, share, vec2(OF_POINT));
    uint whole = whole_of(moved);
    smooth_values[point] = whole;
    smooth_values[params.points + point] = whole;
}
