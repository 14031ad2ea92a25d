// Splines through the window's frames. Their solution is linear in the frames, so that each result is a weighted sum of
// what the frames are off from frame i; the host has solved for the weights.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Poses { float poses[]; };
layout(std430, binding = 2) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 3) readonly buffer Knots { Knot knots[]; };
layout(std430, binding = 4) writeonly buffer Splines { Piece splines[]; };
layout(constant_id = 0) const uint SEGMENTS = 1;
layout(constant_id = 1) const uint SCREEN = 0;  // 1: of pixels and not of clip coordinates

vec3 pose(uint slot, uint point) {
    uint at = 3u * (slot * params.counts.x + point);
    return vec3(poses[at], poses[at + 1u], poses[at + 2u]);
}

float product(vec3 row, vec3 v) {
    precise float sum = row.x * v.x + row.y * v.y + row.z * v.z;
    return sum;
}

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.counts.x) {
        return;
    }
    vec3 at = pose(params.views[1].slot.x, point);
    precise vec3 q = (at - params.views[1].eye.xyz) - params.views[1].eye_low.xyz;
    vec3 start = clip[params.counts.x + point].xyz;
    vec2 pixel = start.xy / start.z;
    precise vec3 sums[4u * SEGMENTS];
    for (uint r = 0u; r < 4u * SEGMENTS; ++r) {
        sums[r] = vec3(0.0);
    }
    for (uint k = 0u; k < params.counts.z; ++k) {
        vec3 way = pose(knots[k].slot.x, point) - at;
        precise vec3 off = vec3(
            product(knots[k].across.xyz, way) + (product(knots[k].across_turn.xyz, q) + knots[k].across.w),
            product(knots[k].down.xyz, way) + (product(knots[k].down_turn.xyz, q) + knots[k].down.w),
            product(knots[k].along.xyz, way) + (product(knots[k].along_turn.xyz, q) + knots[k].along.w));
        if (SCREEN == 1u) {
            precise float depth = start.z + off.z;
            off.xy = (off.xy - pixel * off.z) / depth;
        }
        for (uint r = 0u; r < 4u * SEGMENTS; ++r) {
            sums[r] += knots[k].weights[r / 4u][r % 4u] * off;
        }
    }
    sums[0] = SCREEN == 1u ? vec3(pixel, start.z) : start;
    for (uint s = 0u; s < params.pieces.x; ++s) {
        uint row = 4u * s;
        splines[s * params.pieces.z + point] = Piece(vec4(sums[row], 0.0), vec4(sums[row + 1u], 0.0),
                                                     vec4(sums[row + 2u], 0.0), vec4(sums[row + 3u], 0.0));
    }
}
