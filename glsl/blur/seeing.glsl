// What the frames show of places of the mesh.

layout(binding = 1) uniform utexture2D seen_before;
layout(binding = 2) uniform utexture2D seen_previous;
layout(binding = 3) uniform utexture2D seen_next;
layout(binding = 4) uniform utexture2D seen_after;
layout(binding = 5) uniform texture2D depth_before;
layout(binding = 6) uniform texture2D depth_previous;
layout(binding = 7) uniform texture2D depth_next;
layout(binding = 8) uniform texture2D depth_after;
layout(binding = 9) uniform texture2D frame_before;
layout(binding = 10) uniform texture2D frame_previous;
layout(binding = 11) uniform texture2D frame_next;
layout(binding = 12) uniform texture2D frame_after;
layout(std430, binding = 13) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 14) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 15) readonly buffer Tiles { uint tiles[]; };
#include "tiles.glsl"
#include "triangle_word.glsl"
#include "depths.glsl"

const float LEAST_WEIGHT = 0.25;  // weight of the taps that see it, above which a colour is known

#include "edges.glsl"

uint seen_at(uint frame, ivec2 at) {
    switch (frame) {
        case 0u: return texelFetch(seen_before, at, 0).x;
        case 1u: return texelFetch(seen_previous, at, 0).x;
        case 2u: return texelFetch(seen_next, at, 0).x;
        default: return texelFetch(seen_after, at, 0).x;
    }
}

// View depth; infinite where nothing is seen.
float depth_at(uint frame, ivec2 at) {
    float nearness;
    switch (frame) {
        case 0u: nearness = texelFetch(depth_before, at, 0).x; break;
        case 1u: nearness = texelFetch(depth_previous, at, 0).x; break;
        case 2u: nearness = texelFetch(depth_next, at, 0).x; break;
        default: nearness = texelFetch(depth_after, at, 0).x; break;
    }
    return depth_of(nearness);
}

vec4 colour_at(uint frame, ivec2 at) {
    switch (frame) {
        case 0u: return texelFetch(frame_before, at, 0);
        case 1u: return texelFetch(frame_previous, at, 0);
        case 2u: return texelFetch(frame_next, at, 0);
        default: return texelFetch(frame_after, at, 0);
    }
}

uint cover_at(ivec2 at) {
    return tiles[cover_of(at)];
}

vec3 corner_of(uint frame, uint point) {
    return clip[frame * params.points + point].xyz;
}

bool is_seen(uint frame, ivec2 at, uint surface) {
    uint seen = seen_at(frame, at);
    return seen > 0u && surface_of(triangles[seen - 1u].w) == surface;
}

// The colour of a surface in a pixel that sees it. A pixel at its border is covered in part; the surface is as
// opaque as it is around.
vec4 surface_at(uint frame, ivec2 at, uint surface) {
    vec4 colour = colour_at(frame, at);
    bool is_border = false;
    float opacity = colour.w;
    int around = colour.w > 0.0 && colour.w < 1.0 ? 9 : 0;
    for (int i = 0; i < around; ++i) {
        ivec2 beside = at + ivec2(i % 3, i / 3) - 1;
        if (is_in_picture(beside)) {
            bool is_own = is_seen(frame, beside, surface);
            is_border = is_border || !is_own;
            opacity = is_own ? max(opacity, colour_at(frame, beside).w) : opacity;
        }
    }
    return is_border ? colour * (opacity / colour.w) : colour;
}

// Whether a triangle's plane is as far away as something at a place of the picture. `depths`: of its corners; `own`: where it is seen on
// edge.
bool is_same_depth(vec3 edges, vec3 depths, float own, float other) {
    float sum = edges.x + edges.y + edges.z;
    float volume = dot(edges, depths);
    if (params.is_orthographic != 0u) {
        float there = sum != 0.0 ? volume / sum : own;
        return abs(there - other) <= SAME_DEPTH * params.depth_unit;
    }
    float there = volume != 0.0 ? sum / volume : 1.0 / own;
    float depth = 1.0 / other;
    return abs(there - depth) <= SAME_DEPTH * depth;
}

// The colour that a frame shows of a place of a base triangle, and the weight of the taps that see it.
void look(uint frame, uvec4 triangle, vec3 barycentrics, out vec4 colour, out float weight) {
    vec3 a = corner_of(frame, triangle.x);
    vec3 b = corner_of(frame, triangle.y);
    vec3 c = corner_of(frame, triangle.z);
    vec3 own = barycentrics.x * a + barycentrics.y * b + barycentrics.z * c;
    colour = vec4(0.0);
    weight = 0.0;
    if (!(own.z >= params.near)) {
        return;
    }
    // A place far outside of the picture has no taps, and no whole numbers either.
    vec2 at = clamp(own.xy / widening(own.z) - 0.5, vec2(-2.0), vec2(params.size) + 1.0);
    ivec2 corner = ivec2(floor(at));
    vec2 part = at - vec2(corner);
    for (int i = 0; i < 4; ++i) {
        ivec2 tap = corner + ivec2(i & 1, i >> 1);
        if (!is_in_picture(tap)) {
            continue;
        }
        bool is_outline = (frame == 1u || frame == 2u) && (cover_at(tap) & OUTLINE << frame) != 0u;
        if (is_outline || !is_seen(frame, tap, surface_of(triangle.w))) {
            continue;
        }
        // The triangle's plane goes on beyond it, which is the surface's slope. The same as depths that differ by a share
        // of the plane's.
        vec3 edges = edges_at(a, b, c, vec2(tap) + 0.5);
        if (!is_same_depth(edges, vec3(a.z, b.z, c.z), own.z, depth_at(frame, tap))) {
            continue;
        }
        vec2 both = mix(1.0 - part, part, vec2(i & 1, i >> 1));
        float share = both.x * both.y;
        colour += share * surface_at(frame, tap, surface_of(triangle.w));
        weight += share;
    }
    colour = weight > 0.0 ? colour / weight : colour;
}
