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
layout(constant_id = 4) const uint TEXTURED = 0u;  // 1: base colours have textures
#include "unit.glsl"
#include "toon_tone.glsl"
layout(constant_id = 3) const uint IS_BARE = 0;  // 1: ink is drawn later

// As frame i + 1 sees it: one paint is for both frames.
vec3 paint_of(Fragment fragment) {
    return paint_at(2u, fragment.place, fragment.base, fragment.barycentrics);
}

vec3 tone_in(Fragment fragment, uint frame) {
    uvec4 groups = corner_groups[fragment.place];
    uint first = frame * GROUPS;
    vec3 normal = fragment.barycentrics.x * unit(normals[first + groups.x].xyz)
        + fragment.barycentrics.y * unit(normals[first + groups.y].xyz)
        + fragment.barycentrics.z * unit(normals[first + groups.z].xyz);
    normal = is_turned(frame, fragment.base) ? -normal : normal;
    return tone_at(1u + frame, fragment.base, fragment.barycentrics, unit(normal));
}

vec4 typical(Fragment fragment, uint frame) {
    return vec4(tone_in(fragment, frame) * paint_of(fragment), 1.0);
}

// As the tone of the place changes from the frame that shows it: so an ink line on it stays one.
vec4 predicted(Fragment fragment, uint frame, vec4 known) {
    vec3 paint = paint_of(fragment);
    vec3 hidden = tone_in(fragment, frame) * paint;
    vec3 shown = tone_in(fragment, 1u - frame) * paint;
    vec3 colour = (known.rgb + LEAST_COLOUR) * (hidden + LEAST_COLOUR) / (shown + LEAST_COLOUR) - LEAST_COLOUR;
    return vec4(clamp(colour, vec3(0.0), max(hidden, known.rgb)), known.w);
}

void keep(uint index, Sides sides) {}

// Without ink they need not be looked up.
Sides known_sides(Fragment fragment) {
    if (IS_BARE != 0u) {
        vec3 paint = paint_of(fragment);
        return Sides(vec4[2](vec4(tone_in(fragment, 0u) * paint, 1.0), vec4(tone_in(fragment, 1u) * paint, 1.0)), SHOWN_BOTH);
    }
    return sides_of(fragment, uvec2(1u, 2u), SHOWN_BOTH);
}
