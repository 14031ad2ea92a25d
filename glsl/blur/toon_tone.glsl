// Flat tones of a frame that is drawn.
#include "poses.glsl"
#include "toon/luminance.glsl"
#include "textures.glsl"

// The way to a goal, homogeneous as a light is, from a place of a triangle in a frame, i - 1 (0) to i + 2 (3).
vec3 way_to(vec4 goal, uint frame, uvec4 triangle, vec3 barycentrics) {
    if (goal.w == 0.0) {
        return goal.xyz;
    }
    uint place = params.pose_places[frame];
    vec3 a = goal.xyz - pose(place, triangle.x);
    vec3 b = goal.xyz - pose(place, triangle.y);
    vec3 c = goal.xyz - pose(place, triangle.z);
    vec3 way = barycentrics.x * a + barycentrics.y * b + barycentrics.z * c;
    return dot(way, way) > 0.0 ? normalize(way) : vec3(0.0);
}

// Before it, TEXTURED: whether there are textures.

// What a place of a triangle, whose number is `index`, is painted with, as a sample of a frame sees it.
vec3 paint_at(uint frame, uint index, uvec4 triangle, vec3 barycentrics) {
    vec3 base = barycentrics.x * base_colours[3u * index].rgb + barycentrics.y * base_colours[3u * index + 1u].rgb
        + barycentrics.z * base_colours[3u * index + 2u].rgb;
    if (TEXTURED != 0u) {
        base *= texture_at(frame, index, triangle, barycentrics);
    }
    return max(base, vec3(0.0));
}

// The tone of a place of a triangle by its normal, of length 1 or 0: what its paint is multiplied by.
vec3 tone_at(uint frame, uvec4 triangle, vec3 barycentrics, vec3 normal) {
    float facing = dot(normal, way_to(toon.light, frame, triangle, barycentrics));
    float luminance = luminance_of(facing, 1.0, dot(normal, toon.fill.xyz), toon.ambient, toon.fill.w);
    if (toon.second_strength > 0.0) {
        float second = dot(normal, way_to(toon.second_light, frame, triangle, barycentrics));
        luminance = with_second(luminance, second, toon.second_strength);
    }
    if (toon.rim > 0.0) {
        float eye = dot(normal, way_to(toon.eye, frame, triangle, barycentrics));
        luminance = with_rim(luminance, turned_away(facing, eye), toon.rim);
    }
    vec3 tone = toon.tones[0].rgb;
    for (uint i = 1u; i < toon.tone_count && luminance >= toon.tones[i].w; ++i) {
        tone = toon.tones[i].rgb;
    }
    return tone;
}
