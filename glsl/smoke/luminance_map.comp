// Luminance with a shadow map (paper, section 3.2): slope-scaled bias, percentage-closer filter.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
layout(push_constant) uniform MapConstants { uint texels; } constants;
#define FIRST_PART true
#include "params.glsl"
#include "luminance.glsl"
layout(binding = 7) uniform texture2DArray shadow_map;
layout(std430, binding = 8) readonly buffer ControlBuffer { Control control; };
#include "light.glsl"
#include "light_map.glsl"

// Bias in texels for a depth that changes by `slope` texels a texel: from the surface to the centre of the farthest tap,
// across a corner of the filter, and half a texel.
float bias(float slope) {
    return 0.7072 * float(params.shadow_filter) * min(slope, 16.0) + 0.5;
}

float lit_share(Surface surface, float before) {
    vec3 p = surface.centre + surface.offset;
    float texels = float(constants.texels);
    int taps = int(params.shadow_filter);
    uint face = 0u;
    vec2 at;
    float own;
    if (is_point_light()) {
        vec3 v = p - params.light.xyz;
        face = face_of(v);
        v = on_face(v, face);
        at = 0.5 + 0.5 * v.xy / v.z;
        // Depth is along the face's axis: its slope across the face is not the tangent of the angle to the light.
        vec3 normal = on_face(surface.normal, face);
        float slope = length(normal.xy) / max(-dot(normal, v) / v.z, 0.05);
        own = v.z - bias(slope) * 2.0 * v.z / texels;
    } else {
        float slope = sqrt(max(1.0 - surface.facing * surface.facing, 0.0)) / max(surface.facing, 0.05);
        vec4 frame = map_frame();
        vec3 c = (in_light_space(p) - frame.xyz) / frame.w;
        at = c.xy;
        own = c.z + bias(slope) / texels;
    }
    ivec2 texel = ivec2(floor(at * texels)) - taps / 2;
    int lit = 0;
    for (int y = 0; y < taps; ++y) {
        for (int x = 0; x < taps; ++x) {
            ivec2 tap = clamp(texel + ivec2(x, y), ivec2(0), ivec2(constants.texels - 1u));
            float stored = texelFetch(shadow_map, ivec3(tap, face), 0).x;
            bool blocked = is_point_light() ? stored > 0.0 && map_near() / stored < own : stored > own;
            lit += blocked ? 0 : 1;
        }
    }
    return float(lit) / float(taps * taps);
}
