// Flat tones of a frame that is drawn.
#include "poses.glsl"
#include "toon/luminance.glsl"

// The way to the light from a place of a triangle in a frame, i - 1 (0) to i + 2 (3).
vec3 to_light(uint frame, uvec4 triangle, vec3 barycentrics) {
    if (toon.light.w == 0.0) {
        return toon.light.xyz;
    }
    uint place = params.pose_places[frame];
    vec3 a = toon.light.xyz - pose(place, triangle.x);
    vec3 b = toon.light.xyz - pose(place, triangle.y);
    vec3 c = toon.light.xyz - pose(place, triangle.z);
    vec3 way = barycentrics.x * a + barycentrics.y * b + barycentrics.z * c;
    return dot(way, way) > 0.0 ? normalize(way) : vec3(0.0);
}

// The tone of a place of a triangle, whose number is `index`, by its normal, of length 1 or 0.
vec3 toned(uint frame, uint index, uvec4 triangle, vec3 barycentrics, vec3 normal) {
    float facing = dot(normal, to_light(frame, triangle, barycentrics));
    float luminance = luminance_of(facing, 1.0, dot(normal, toon.fill.xyz), toon.ambient, toon.fill.w);
    vec3 tone = toon.tones[0].rgb;
    for (uint i = 1u; i < toon.tone_count && luminance >= toon.tones[i].w; ++i) {
        tone = toon.tones[i].rgb;
    }
    vec3 base = barycentrics.x * base_colours[3u * index].rgb + barycentrics.y * base_colours[3u * index + 1u].rgb
        + barycentrics.z * base_colours[3u * index + 2u].rgb;
    return tone * max(base, vec3(0.0));
}
