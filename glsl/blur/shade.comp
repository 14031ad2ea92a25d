// Samples of images.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "samples.glsl"
#include "tones.glsl"
#include "sides.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
#include "seeing.glsl"
#include "fragment.glsl"
#include "shade.glsl"
layout(std430, binding = 21) readonly buffer Tables { uvec4 tables[]; };
layout(std430, binding = 25) writeonly buffer SampleSides { uvec4 sample_sides[]; };

// What the surface looks like at the place's normal.
vec4 typical(Fragment fragment, uint frame) {
    uint surface = surface_of(fragment.base.w);
    uint bin = bin_of(normal_at(frame, fragment.place, fragment.base, fragment.barycentrics));
    if (surface >= params.tables || bin == NONE) {
        return vec4(-1.0);
    }
    uvec4 units = tables[table_of(surface, frame) + bin];
    return units.x == NONE ? vec4(-1.0) : vec4(units) * (scale_of_images() / UNITS);
}

// Whether tones explain how colours change: of all at least a quarter, and of a surface what it must.
bool is_explained(uint surface) {
    uint own = SURFACES + 2u * surface;
    bool is_own = surface >= params.tables || completing[own] <= completing[own + 1u];
    return is_own && 4u * completing[UNEXPLAINED] <= 3u * completing[UNEXPLAINED + 1u];
}

// The logarithm of the tone at a normal. Between neighbours that differ little it changes evenly, between others at once.
vec3 tone_at(uint place, uint frame, vec3 normal) {
    vec3 light = uintBitsToFloat(tables[row_of_light(place, frame)].xyz);
    uint nearest = step_of(light, normal, TONE_STEPS);
    float beside = (dot(light, normal) * 0.5 + 0.5) * float(TONE_STEPS) - (float(nearest) + 0.5);
    uint next = uint(clamp(int(nearest) + (beside < 0.0 ? -1 : 1), 0, int(TONE_STEPS) - 1));
    ivec3 own = ivec3(tables[row_of_tone(place, nearest)].xyz);
    ivec3 way = ivec3(tables[row_of_tone(place, next)].xyz) - own;
    bool is_even = abs(way.x) + abs(way.y) + abs(way.z) < EVEN;
    return vec3(own) + (is_even ? min(abs(beside), 0.5) * vec3(way) : vec3(0.0));
}

// It changes as the tone does.
vec4 predicted(Fragment fragment, uint frame, vec4 known) {
    uint surface = surface_of(fragment.base.w);
    vec3 hidden = unit(normal_at(frame, fragment.place, fragment.base, fragment.barycentrics));
    vec3 shown = unit(normal_at(1u - frame, fragment.place, fragment.base, fragment.barycentrics));
    if (params.tables == 0u || hidden == vec3(0.0) || shown == vec3(0.0) || !is_explained(surface)) {
        return vec4(-1.0);
    }
    uint place = surface < params.tables ? 1u + surface : 0u;
    vec3 change = (tone_at(place, frame, hidden) - tone_at(place, 1u - frame, shown)) / LOGARITHM;
    vec3 colour = (max(known.xyz, vec3(0.0)) + LEAST_COLOUR) * exp(change) - LEAST_COLOUR;
    return vec4(clamp(colour, vec3(0.0), max(vec3(scale_of_images()), known.xyz)), known.w);
}

Sides known_sides(Fragment fragment) {
    return sides_of(fragment, uvec2(1u, 2u), SHOWN_BOTH);
}

void keep(uint index, Sides sides) {
    if (COMPLETION == FROM_GRADIENT) {
        sample_sides[index] = uvec4(packed(sides.colours[0]), packed(sides.colours[1]));
    }
}
