// Divides the triangles of a round: what is not divided is finished. The order is that of the triangles before. And what the next round is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = BLOCK) in;
layout(std430, binding = 1) buffer Splines { Piece splines[]; };
layout(std430, binding = 2) buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 3) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 4) readonly buffer Bounds { vec2 bounds[]; };
layout(std430, binding = 5) buffer Rounds { Round rounds[]; };
layout(std430, binding = 6) readonly buffer Active { uvec4 active_triangles[]; };
layout(std430, binding = 7) writeonly buffer Next { uvec4 next_triangles[]; };
layout(std430, binding = 8) writeonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 9) readonly buffer PartSums { uvec2 block_sums[]; };
layout(std430, binding = 10) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 11) buffer ControlBuffer { Control control; };
#include "round.glsl"
#include "curve.glsl"
#include "extent.glsl"
#include "vertex.glsl"
#include "parts.glsl"
#include "base.glsl"
#define SCAN_TYPE uvec2
#define SCAN_BLOCKS
#include "common/scan.glsl"

const uint ALL_OPEN = 7u;

void add_vertex(uint to, uint a, uint b, uint base) {
    for (uint s = 0u; s < params.segment_count; ++s) {
        splines[s * params.vertex_room + to] = piece_of(a, b, 2u, s);
    }
    Vertex vertex = vertex_between(a, b, 2u);
    uvec4 triangle = triangles[base];
    vertex.barycentrics = (barycentrics_of(a, triangle) + barycentrics_of(b, triangle)) * 0.5;
    vertices[to] = vertex;
}

void add(inout uint at, uvec3 corners, uint base, uint open) {
    next_triangles[at] = uvec4(corners, base | open << OPEN_SHIFT);
    at += 1u;
}

// Whether the first of two diagonals is the shorter one; of equal ones, which new vertex is farther to the left, or up.
bool is_shorter(float own, vec2 p, float other, vec2 q) {
    return own < other || own == other && (p.x < q.x || p.x == q.x && p.y <= q.y);
}

void divide(uvec4 triangle, uint at, uint made) {
    uint base = triangle.w & BASE_MASK;
    uint split = triangle.w >> SPLIT_SHIFT & 7u;
    // Turned so that of one split edge it is the first, and of two they meet in the first corner.
    uint turns = split == 2u || split == 3u ? 1u : split == 4u || split == 6u ? 2u : 0u;
    uvec3 corners = turns == 0u ? triangle.xyz : turns == 1u ? triangle.yzx : triangle.zxy;
    uint a = corners.x;
    uint b = corners.y;
    uint c = corners.z;
    uint ab = made;
    uint ca = made + 1u;
    uint bc = made + 2u;
    for (uint i = 0u; i < bitCount(split); ++i) {
        add_vertex(made + i, i == 0u ? a : i == 1u ? c : b, i == 0u ? b : i == 1u ? a : c, base);
    }
    if (bitCount(split) == 1) {
        add(at, uvec3(a, ab, c), base, 3u);
        add(at, uvec3(ab, b, c), base, 5u);
        return;
    }
    add(at, uvec3(a, ab, ca), base, ALL_OPEN);
    if (bitCount(split) == 2) {
        vec2 first = vertices[ab].drawn;
        vec2 second = vertices[ca].drawn;
        float own = distance2(first, vertices[c].drawn);
        if (is_shorter(own, first, distance2(vertices[b].drawn, second), second)) {
            add(at, uvec3(ab, b, c), base, 5u);
            add(at, uvec3(ab, c, ca), base, ALL_OPEN);
        } else {
            add(at, uvec3(ab, b, ca), base, ALL_OPEN);
            add(at, uvec3(b, c, ca), base, 6u);
        }
        return;
    }
    add(at, uvec3(ab, b, bc), base, ALL_OPEN);
    add(at, uvec3(ca, bc, c), base, ALL_OPEN);
    add(at, uvec3(ab, bc, ca), base, ALL_OPEN);
}

// The next round has what is divided, `made` triangles of `divided` ones.
void begin_next(Round current, uint made, uint divided) {
    uint finished_before = current.finished_before + current.triangles - divided;
    uint vertices_before = current.vertices_before + made - divided;
    if (constants.round < ROUNDS) {
        uint groups = (made + BLOCK - 1u) / BLOCK;
        rounds[constants.round + 1u] = Round(uvec4(groups, 1u, 1u, 0u), made, finished_before, vertices_before, 0u);
    }
    control.triangles = finished_before;
    control.vertices = vertices_before;
    control.draw = uvec4(3u * finished_before, 1u, 0u, 0u);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    Round current = rounds[constants.round];
    bool exists = index < current.triangles;
    uvec4 triangle = exists ? active_triangles[index] : uvec4(0u);
    Scan blocks = scan_blocks(gl_WorkGroupID.x, current.groups.x);
    bool is_over = current.finished_before + current.triangles - blocks.all.y + blocks.all.x > params.triangle_budget;
    // It would divide some, and must not.
    bool is_last = blocks.all.x > 0u && (is_over || constants.round == ROUNDS);
    uvec2 parts = exists && !is_last ? parts_of(triangle.w) : uvec2(0u);
    uvec2 before = (is_last ? uvec2(0u) : blocks.before) + scan_workgroup(parts).before;
    if (index == 0u) {
        if (is_last) {
            control.ended_by = is_over ? ENDED_BY_BUDGET : ENDED_BY_ROUNDS;
            control.undivided = blocks.all.y;
        }
        begin_next(current, is_last ? 0u : blocks.all.x, is_last ? 0u : blocks.all.y);
    }
    if (!exists) {
        return;
    }
    if (parts.x > 0u) {
        divide(triangle, before.x, current.vertices_before + before.x - before.y);
    } else {
        uint kept = (triangle.w >> OPEN_SHIFT) == 0u ? triangle.w & (BASE_MASK | CULLED) : triangle.w & BASE_MASK;
        finished[current.finished_before + index - before.y] = uvec4(triangle.xyz, kept);
    }
}
