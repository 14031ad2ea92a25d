// The foremost and the rearmost place of each row of a part: its points and the edges between them, where they are nearer to it
// than to other rows.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "directions.glsl"
#include "rows.glsl"
#include "along.glsl"
#include "../common/bits.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Motions { PointMotion motions[]; };
layout(std430, binding = 2) readonly buffer Labels { uint labels[]; };
layout(std430, binding = 3) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 4) readonly buffer NeighbourStarts { uint neighbour_starts[]; };
layout(std430, binding = 5) readonly buffer Neighbours { uint neighbours[]; };
layout(std430, binding = 6) buffer RowValues { uint row_values[]; };  // two a row: of the front, and of the rear turned around

// How far ahead a point is, and how many rows aside.
vec2 row_place(Cluster cluster, uint point) {
    vec2 position = motions[point].position;
    float rows = float(rows_of(cluster) - 1u);
    float aside = along(vec2(cluster.ahead.y, -cluster.ahead.x), position) - cluster.aside;
    return vec2(along(cluster.ahead, position), rows > 0.0 ? aside * (rows / cluster.width) : 0.0);
}

void add(Cluster cluster, vec2 from, vec2 to) {
    if (from.y > to.y) {
        vec2 other = from;
        from = to;
        to = other;
    }
    float last = float(rows_of(cluster) - 1u);
    uint first = uint(clamp(ceil(from.y - 0.5), 0.0, last));
    uint end = uint(clamp(floor(to.y + 0.5), 0.0, last));
    float rows = to.y - from.y;
    for (uint row = first; row <= end; ++row) {
        vec2 borders = float(row) + vec2(-0.5, 0.5);
        vec2 shares = rows > 0.0 ? clamp((borders - from.y) / rows, 0.0, 1.0) : vec2(0.0);
        vec2 ahead = mix(vec2(from.x), vec2(to.x), shares);
        uint at = 2u * (cluster.bounds_begin + row);
        atomicMax(row_values[at], ordered(max(ahead.x, ahead.y)));
        atomicMax(row_values[at + 1u], ordered(-min(ahead.x, ahead.y)));
    }
}

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.points || labels[point] == 0u) {
        return;
    }
    uint label = labels[point];
    Cluster cluster = clusters[label - 1u];
    if (cluster.ahead == vec2(0.0)) {
        return;
    }
    vec2 own = row_place(cluster, point);
    add(cluster, own, own);
    for (uint i = neighbour_starts[point]; i < neighbour_starts[point + 1u]; ++i) {
        uint other = neighbours[i];
        if (other > point && labels[other] == label) {
            add(cluster, own, row_place(cluster, other));
        }
    }
}
