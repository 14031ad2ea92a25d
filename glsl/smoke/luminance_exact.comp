// Luminance with exact shadows: the ray from the surface to the light against the spheres of its light-space tiles, in
// closed form. The pixel's own sphere is left out by its index, so nothing shadows itself by rounding.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(push_constant) uniform LuminanceConstants {
    uint part;     // which part of the lists
    uint entries;  // of them a part
} constants;
#define FIRST_PART (constants.part == 0u)
#include "params.glsl"
#include "luminance.glsl"
layout(std430, binding = 7) readonly buffer Cells { uint cell_ends[]; };
layout(std430, binding = 8) readonly buffer Casters { uint casters[]; };
#include "light.glsl"

float lit_by(vec4 caster, Surface surface) {
    vec3 to_caster = (caster.xyz - surface.centre) - surface.offset;
    float closest = dot(to_caster, surface.to_light);
    vec3 across = to_caster - closest * surface.to_light;
    float inside = caster.w * caster.w - dot(across, across);
    if (inside > 0.0) {
        float half_chord = sqrt(inside);
        return closest + half_chord > 0.0 && closest - half_chord < surface.light_distance ? 0.0 : 1.0;
    }
    if (params.softness > 0.0 && closest > 0.0 && closest < surface.light_distance) {
        return clamp((length(across) - caster.w) / (params.softness * closest), 0.0, 1.0);
    }
    return 1.0;
}

float lit_share(Surface surface, float before) {
    vec3 p = surface.centre + surface.offset;
    uint face = is_point_light() ? face_of(p - params.light.xyz) : 0u;
    vec2 position = face_position(p, face);
    // A bucket of its own for rounding: what is in later buckets lies behind the surface.
    uint last_bucket = bucket_of(light_distance(p) + 1e-4 * length(surface.offset));
    uint begin = constants.part * constants.entries;
    uint end = begin + constants.entries;
    uint passed = 0u;
    float s = before;
    for (uint level = 0u; level < params.light_levels && s > 0.0; ++level) {
        uint cell = cell_at(face, level, position);
        uint list = cell == 0u ? 0u : cell_ends[cell * BUCKETS - 1u];
        uint count = cell_ends[cell * BUCKETS + last_bucket] - list;
        uint from = begin > passed ? min(begin - passed, count) : 0u;
        uint to = end > passed ? min(end - passed, count) : 0u;
        for (uint i = from; i < to && s > 0.0; ++i) {
            uint slot = casters[list + i];
            if (slot != surface.slot) {
                s = min(s, lit_by(spheres[slot], surface));
            }
        }
        passed += count;
    }
    return s;
}
