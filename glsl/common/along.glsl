// A row of a matrix times the way from the eye, each given as a sum of two floats.
#ifndef ALONG
#define ALONG

#include "exact.glsl"

// Result, and about what it lost in rounding.
vec2 along_parts(vec3 row, vec3 row_low, vec3 q, vec3 q_low) {
    vec2 x = two_product(row.x, q.x);
    vec2 y = two_product(row.y, q.y);
    vec2 z = two_product(row.z, q.z);
    vec2 xy = two_sum(x.x, y.x);
    vec2 xyz = two_sum(xy.x, z.x);
    float low = x.y + y.y + z.y + xy.y + xyz.y + dot(row, q_low) + dot(row_low, q);
    return vec2(xyz.x, low);
}

// Rounded about once.
float along_row(vec3 row, vec3 row_low, vec3 q, vec3 q_low) {
    vec2 parts = along_parts(row, row_low, q, q_low);
    return parts.x + parts.y;
}

#endif
