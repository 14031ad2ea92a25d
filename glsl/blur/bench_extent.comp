// k and l of the mesh's points from all points of their clusters, some of them at a time: the paper's sums as they are
// written. The products are those of extent.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Motions { PointMotion motions[]; };
layout(std430, binding = 2) readonly buffer Labels { uint labels[]; };
layout(std430, binding = 3) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 4) readonly buffer Bounds { vec2 bounds[]; };
layout(std430, binding = 5) buffer Extremes { vec4 extremes_so_far[]; };
layout(std430, binding = 6) writeonly buffer BruteExtents { vec2 brute_extents[]; };
layout(push_constant) uniform BenchExtentConstants {
    uint first;  // of the points that are looked at
    uint end;    // and the one after the last
} constants;
#include "extent.glsl"

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.points) {
        return;
    }
    PointMotion motion = motions[point];
    uint label = labels[point];
    vec2 d;
    if (label == 0u || !direction_of(motion.velocity, d)) {
        brute_extents[point] = vec2(1.0, 0.0);
        return;
    }
    vec2 u = vec2(d.y, -d.x);
    vec4 found = constants.first > 0u ? extremes_so_far[point]
        : vec4(vec2(along(d, motion.position)), vec2(along(u, motion.position)));
    for (uint other = constants.first; other < constants.end; ++other) {
        if (labels[other] == label) {
            vec2 q = motions[other].position;
            float ahead = along(d, q);
            float aside = along(u, q);
            found.xz = min(found.xz, vec2(ahead, aside));
            found.yw = max(found.yw, vec2(ahead, aside));
        }
    }
    extremes_so_far[point] = found;
    brute_extents[point] = shares_of(found, motion.position, d, u);
}
