// Where the mesh's points are drawn.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Smooth { float smooth_values[]; };
layout(std430, binding = 2) readonly buffer Splines { Piece splines[]; };
layout(std430, binding = 3) buffer Vertices { Vertex vertices[]; };
layout(push_constant) uniform SettleConstants {
    uint from;  // which half of the smoothed values is the last: 0 or 1
} constants;
#include "curve.glsl"

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.counts.x) {
        return;
    }
    float raw = vertices[point].extent.w;
    float moved = smooth_values[constants.from * params.counts.x + point];
    precise float added = moved - raw;
    vertices[point].extent.zw = vec2(added, moved);
    vertices[point].drawn = vec4(clip_at(point, point, 0u, moved), moved);
}
