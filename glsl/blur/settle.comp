// Where the mesh's points are drawn.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Smooth { uint smooth_values[]; };
layout(std430, binding = 2) readonly buffer Splines { Piece splines[]; };
layout(std430, binding = 3) buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 4) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 5) readonly buffer Bounds { vec2 bounds[]; };
layout(push_constant) uniform SettleConstants {
    uint from;  // which half of the smoothed values is the last: 0 or 1
} constants;
#include "curve.glsl"
#include "extent.glsl"

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.points) {
        return;
    }
    float moved = vertices[point].time;
    int change = int(whole_of(moved)) - int(smooth_values[constants.from * params.points + point]);
    precise float added = float(change) * (1.0 / UNIT);
    if (vertices[point].cluster > 0u) {
        moved = shifted(moved, added);
    }
    State state = state_at(point, point, 0u, moved);
    vertices[point].smoothing = added;
    vertices[point].time = moved;
    vertices[point].drawn = state.position;
    vertices[point].drawn_depth = state.depth;
    vertices[point].drawn_time = moved;
}
