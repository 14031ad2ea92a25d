// Which edges are split in a round. An edge's ends alone decide, so that both of its triangles agree.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "common/bits.glsl"
layout(local_size_x = BLOCK) in;
layout(std430, binding = 1) readonly buffer Splines { Piece splines[]; };
layout(std430, binding = 2) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 3) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 4) readonly buffer Bounds { vec2 bounds[]; };
layout(std430, binding = 5) readonly buffer Rounds { Round rounds[]; };
layout(std430, binding = 6) buffer Active { uvec4 active_triangles[]; };
layout(std430, binding = 7) writeonly buffer PartSums { uvec2 block_sums[]; };
#include "round.glsl"
layout(constant_id = 1) const uint BY_LENGTH = 0;  // 1: long edges are split, whatever they look like
#include "curve.glsl"
#include "extent.glsl"
#include "vertex.glsl"
#include "parts.glsl"
#define SCAN_TYPE uvec2
#include "common/scan.glsl"

// What is drawn of an edge at a quarter, half or three quarters of it.
vec2 straight_at(vec2 from, vec2 to, uint where) {
    precise vec2 half_way = (from + to) * 0.5;
    vec2 near = where == 1u ? from : to;
    vec2 far = where == 1u ? to : from;
    precise vec2 quarter = near + (far - near) * 0.25;
    return where == 2u ? half_way : quarter;
}

// How far a place is beyond the left, upper, right and lower border of the picture, in pixels. What is not in front of the
// camera is nowhere.
vec4 beyond(vec2 drawn, float depth) {
    precise vec4 far = vec4(-drawn, drawn - vec2(params.size));
    return depth > 0.0 ? far : vec4(-1.0);
}

vec4 nearer(vec4 found, vec4 known) {
    return mix(known, found, lessThan(found, known));
}

float largest(vec4 v) {
    return max(max(v.x, v.y), max(v.z, v.w));
}

bool is_split(uint a, uint b) {
    vec2 from = vertices[a].drawn;
    vec2 to = vertices[b].drawn;
    float length2 = distance2(from, to);
    bool is_long = length2 >= LEAST_EDGE * LEAST_EDGE && length2 < INFINITY;
    if (!is_long || max(vertices[a].cluster, vertices[b].cluster) == 0u) {
        return false;
    }
    vec4 outside = params.is_clipped != 0u
        ? nearer(beyond(to, vertices[b].drawn_depth), beyond(from, vertices[a].drawn_depth)) : vec4(-1.0);
    bool is_seen = !(largest(outside) > 0.0);
    bool is_too_long = length2 > params.edge * params.edge;
    if (BY_LENGTH == 1u && (is_seen || !is_too_long)) {
        return is_too_long;
    }
    // Where k' jumps, as in the middle of what spins, parts of an edge stay long for ever.
    if (BY_LENGTH == 0u
        && distance2(vertices[a].position, vertices[b].position) < LEAST_SURFACE * LEAST_SURFACE) {
        return false;
    }
    // An edge may be straight enough where it is looked at and its parts not: then needles to its ends are divided again and
    // again, each of half the area. An edge is looked at in one round, by both of its triangles.
    float tolerance = params.tolerance * float(1u << (max(constants.round, USUAL_ROUNDS) - USUAL_ROUNDS));
    precise float most = tolerance * tolerance;
    float departure = 0.0;
    for (uint i = 0u; i < 3u && !(is_seen && departure > most); ++i) {
        uint where = i == 0u ? 2u : i == 1u ? 1u : 3u;
        Vertex vertex = vertex_between(a, b, where);
        float off = distance2(vertex.drawn, straight_at(from, to, where));
        departure = off > departure ? off : departure;
        outside = nearer(beyond(vertex.drawn, vertex.drawn_depth), outside);
        is_seen = !(largest(outside) > 0.0);
    }
    // Nobody sees an edge that is beyond one border by more than it is off the straight line.
    float far = max(largest(outside), 0.0);
    precise float far2 = far * far;
    return (BY_LENGTH == 1u || departure > most) && !(far2 > departure);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    uvec2 parts = uvec2(0u);
    if (index < rounds[constants.round].triangles) {
        uvec4 triangle = active_triangles[index];
        uint open = triangle.w >> OPEN_SHIFT;
        if (open != 0u) {
            uint split = 0u;
            for (uint edge = 0u; edge < 3u; ++edge) {
                uint next = edge == 2u ? 0u : edge + 1u;
                if ((open >> edge & 1u) != 0u && is_split(triangle[edge], triangle[next])) {
                    split |= 1u << edge;
                }
            }
            triangle.w = triangle.w & ~(7u << SPLIT_SHIFT) | split << SPLIT_SHIFT;
            active_triangles[index].w = triangle.w;
            parts = parts_of(triangle.w);
        }
    }
    uvec2 all = scan_workgroup(parts).all;
    if (gl_LocalInvocationID.x == 0u) {
        block_sums[gl_WorkGroupID.x] = all;
    }
}
