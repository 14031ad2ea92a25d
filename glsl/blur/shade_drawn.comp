// Samples of frames that are drawn here: what they hide is drawn, too, and need not be guessed.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "samples.glsl"
#include "toon.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
#include "seeing.glsl"
#include "fragment.glsl"
#include "shade.glsl"
layout(std430, binding = 26) readonly buffer Poses { float poses[]; };
#include "unit.glsl"
#include "toon_tone.glsl"
layout(constant_id = 3) const uint IS_BARE = 0;  // 1: ink is drawn later

vec4 typical(Fragment fragment, uint frame) {
    uvec4 groups = corner_groups[fragment.place];
    uint first = frame * GROUPS;
    vec3 normal = fragment.barycentrics.x * unit(normals[first + groups.x].xyz)
        + fragment.barycentrics.y * unit(normals[first + groups.y].xyz)
        + fragment.barycentrics.z * unit(normals[first + groups.z].xyz);
    normal = is_turned(frame, fragment.base) ? -normal : normal;
    return vec4(toned(1u + frame, fragment.place, fragment.base, fragment.barycentrics, unit(normal)), 1.0);
}

// As the tone of the place changes from the frame that shows it: so an ink line on it stays one.
vec4 predicted(Fragment fragment, uint frame, vec4 known) {
    vec3 hidden = typical(fragment, frame).rgb;
    vec3 shown = typical(fragment, 1u - frame).rgb;
    vec3 colour = (known.rgb + LEAST_COLOUR) * (hidden + LEAST_COLOUR) / (shown + LEAST_COLOUR) - LEAST_COLOUR;
    return vec4(clamp(colour, vec3(0.0), max(hidden, known.rgb)), known.w);
}

void keep(uint index, Sides sides) {}

// Without ink they need not be looked up.
Sides known_sides(Fragment fragment) {
    if (IS_BARE != 0u) {
        return Sides(vec4[2](typical(fragment, 0u), typical(fragment, 1u)), SHOWN_BOTH);
    }
    return sides_of(fragment, uvec2(1u, 2u), SHOWN_BOTH);
}
