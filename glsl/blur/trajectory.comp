// Splines through the window's frames. Their solution is linear in the frames, so that each result is a weighted sum of
// what the frames are off from frame i; the host has solved for the weights.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/along.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Poses { float poses[]; };
layout(std430, binding = 2) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 3) readonly buffer Knots { Knot knots[]; };
layout(std430, binding = 4) writeonly buffer Splines { Piece splines[]; };
layout(constant_id = 0) const uint SEGMENTS = 1;
layout(constant_id = 1) const uint SCREEN = 0;  // 1: of pixels and not of clip coordinates

#include "poses.glsl"
#include "common/widening.glsl"

// How far a coordinate is off from frame i's: by the point's own way, and by the camera's. The camera's turn and its way
// take away most of each other where it goes around something.
float off_by(vec4 row, vec4 row_low, vec4 turn, vec4 turn_low, vec3 way, vec3 q, vec3 q_low, bool is_other) {
    vec2 own = along_parts(row.xyz, row_low.xyz, way, vec3(0.0));
    vec2 turned = is_other ? along_parts(turn.xyz, turn_low.xyz, q, q_low) : vec2(0.0);
    vec2 moved = two_sum(turned.x, row.w);
    vec2 sum = two_sum(moved.x, own.x);
    precise float low = own.y + turned.y + row_low.w + moved.y + sum.y;
    precise float off = sum.x + low;
    return off;
}

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.points) {
        return;
    }
    vec3 at = pose(params.pose_places[1], point);
    View view = params.views[1];
    vec2 x = two_sum(at.x, -view.eye.x);
    vec2 y = two_sum(at.y, -view.eye.y);
    vec2 z = two_sum(at.z, -view.eye.z);
    vec3 q = vec3(x.x, y.x, z.x);
    vec3 q_low = vec3(x.y, y.y, z.y) - view.eye_low.xyz;
    vec3 start = clip[params.points + point].xyz;
    // Trajectories are of frame i + 1's picture.
    start.xy += params.jitter_change * widening(start.z);
    bool is_parallel = params.is_orthographic != 0u;
    vec2 pixel = start.xy / widening(start.z);
    precise vec3 sums[4u * SEGMENTS];
    for (uint r = 0u; r < 4u * SEGMENTS; ++r) {
        sums[r] = vec3(0.0);
    }
    for (uint k = 0u; k < params.knots; ++k) {
        vec3 way = pose(knots[k].pose_place, point) - at;
        Knot knot = knots[k];
        bool is_other = knot.has_other_view != 0u;
        precise vec3 off = vec3(
            off_by(knot.across, knot.across_low, knot.across_turn, knot.across_turn_low, way, q, q_low, is_other),
            off_by(knot.down, knot.down_low, knot.down_turn, knot.down_turn_low, way, q, q_low, is_other),
            off_by(knot.along, knot.along_low, knot.along_turn, knot.along_turn_low, way, q, q_low, is_other));
        if (SCREEN == 1u && !is_parallel) {
            precise float depth = start.z + off.z;
            off.xy = (off.xy - pixel * off.z) / depth;
        }
        for (uint r = 0u; r < 4u * SEGMENTS; ++r) {
            sums[r] += knots[k].weights[r / 4u][r % 4u] * off;
        }
    }
    sums[0] = SCREEN == 1u ? vec3(pixel, start.z) : start;
    for (uint s = 0u; s < params.segment_count; ++s) {
        uint row = 4u * s;
        splines[s * params.vertex_room + point] = Piece(vec4(sums[row], 0.0), vec4(sums[row + 1u], 0.0),
                                                     vec4(sums[row + 2u], 0.0), vec4(sums[row + 3u], 0.0));
    }
}
