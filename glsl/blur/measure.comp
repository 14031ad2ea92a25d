// Where points are at the reference time and how they move there, and which of them move at all: from their trajectories.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer PartLabels { uint part_labels[]; };
layout(std430, binding = 2) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 3) readonly buffer Splines { Piece splines[]; };
layout(std430, binding = 4) writeonly buffer Motions { PointMotion motions[]; };
layout(std430, binding = 5) writeonly buffer Labels { uint labels[]; };
#include "curve.glsl"
#include "../common/bits.glsl"
#include "common/widening.glsl"

// A bound of depth from below: a cubic stays within its Bezier points.
float lowest_depth(Piece piece, float start) {
    float a = start;
    float b = start + piece.step.z;
    float third = (1.0 / 3.0) * piece.step.z;
    float slope_begin = third - (2.0 * piece.bend_begin.z + piece.bend_end.z) * (1.0 / 18.0);
    float slope_end = third + (piece.bend_begin.z + 2.0 * piece.bend_end.z) * (1.0 / 18.0);
    return min(min(a, b), min(a + slope_begin, b - slope_end));
}

// Whether the point is before the camera in frames i - 1 to i + 2, and wherever trajectories are looked at.
bool is_seen(uint point) {
    bool seen = true;
    for (uint i = 0u; i < 4u; ++i) {
        seen = seen && clip[i * params.points + point].z > params.near;
    }
    float start = splines[point].origin.z;
    for (uint s = 0u; s < params.segment_count; ++s) {
        Piece piece = splines[s * params.vertex_room + point];
        seen = seen && lowest_depth(piece, s == 0u ? start : start + piece.origin.z) > 0.0;
    }
    float behind = state_at(point, point, 0u, -params.reach).depth;
    float ahead = params.lead > 0.0 ? state_at(point, point, 0u, 1.0 + params.lead).depth : behind;
    return seen && min(behind, ahead) > 0.0;
}

vec2 pixel_at(uint frame, uint point) {
    vec3 at = clip[frame * params.points + point].xyz;
    return at.xy / (params.is_orthographic != 0u ? 1.0 : at.z);
}

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.points) {
        return;
    }
    PointMotion motion = PointMotion(vec2(0.0), vec2(0.0));
    bool moves = false;
    if (is_seen(point)) {
        State state = state_at(point, point, 0u, params.reference_time);
        vec2 way = pixel_at(2u, point) - pixel_at(1u, point) - params.jitter_change;
        bool is_number = is_finite(state.position.x) && is_finite(state.position.y) && is_finite(state.velocity.x) && is_finite(state.velocity.y);
        motion = is_number ? PointMotion(state.position, state.velocity) : motion;
        moves = is_number && length(way) >= STATIC;
    }
    motions[point] = motion;
    labels[point] = moves ? part_labels[point] : 0u;
}
