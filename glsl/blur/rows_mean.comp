// Front and rear of each row of a part: what has nothing lies between the rows beside it; means over some rows to both sides.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "directions.glsl"
#include "rows.glsl"
#include "../common/bits.glsl"
layout(local_size_x = MOST_ROWS) in;
layout(std430, binding = 1) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 2) readonly buffer RowValues { uint row_values[]; };
layout(std430, binding = 3) writeonly buffer Bounds { vec2 bounds[]; };

shared uvec2 values[MOST_ROWS];
shared vec2 filled[MOST_ROWS];

// Rear and front.
vec2 bounds_at(uint row) {
    return vec2(-from_ordered(values[row].y), from_ordered(values[row].x));
}

void main() {
    uint row = gl_LocalInvocationID.x;
    Cluster cluster = clusters[gl_WorkGroupID.x];
    uint count = cluster.ahead == vec2(0.0) ? 0u : rows_of(cluster);
    uint at = cluster.bounds_begin + row;
    values[row] = row < count ? uvec2(row_values[2u * at], row_values[2u * at + 1u]) : uvec2(0u);
    barrier();
    if (row < count) {
        uint before = row;
        while (before > 0u && values[before].x == 0u) {
            --before;
        }
        uint after = row;
        while (after + 1u < count && values[after].x == 0u) {
            ++after;
        }
        // The first and the last have a point, but for rounding.
        before = values[before].x == 0u ? after : before;
        after = values[after].x == 0u ? before : after;
        float share = after > before ? float(row - before) / float(after - before) : 0.0;
        filled[row] = mix(bounds_at(before), bounds_at(after), share);
    }
    barrier();
    if (row < count) {
        vec2 sum = vec2(0.0);
        uint far = min(SMOOTHED, min(row, count - 1u - row));
        for (uint i = row - far; i <= row + far; ++i) {
            sum += filled[i];
        }
        bounds[at] = sum / float(2u * far + 1u);
    }
}
