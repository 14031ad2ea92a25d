// A frame of flat tones with ink lines, at four samples a pixel: the mesh alone, premultiplied.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "picture.glsl"
#include "toon.glsl"
layout(binding = 1) uniform utexture2D sampled;
layout(std430, binding = 2) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 3) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 4) readonly buffer Poses { float poses[]; };
layout(std430, binding = 6) readonly buffer Normals { vec4 normals[]; };
layout(std430, binding = 7) readonly buffer Lines { float lines[]; };
layout(std430, binding = 9) readonly buffer CornerGroups { uvec4 corner_groups[]; };
#include "frame.glsl"
layout(constant_id = 0) const uint INKED = 1u;  // 0: no line
layout(constant_id = 1) const int REACH = 1;    // samples from which a line can reach a sample
layout(constant_id = 2) const uint TEXTURED = 0u;  // 1: base colours have textures
layout(location = 0) out vec4 colour;

#include "edges.glsl"
#include "normal_order.glsl"
#include "unit.glsl"
#include "toon_tone.glsl"
#include "common/fragment.glsl"

// Unit normal of a group; 0 where it has no area.
vec3 normal_of(uint group) {
    return unit(normals[place_of_normals(constants.frame) * toon.groups + group].xyz);
}

vec3 tone_of(uint index, vec2 at) {
    uvec4 triangle = triangles[index];
    uint first = constants.frame * params.points;
    vec3 a = clip[first + triangle.x].xyz;
    vec3 b = clip[first + triangle.y].xyz;
    vec3 c = clip[first + triangle.z].xyz;
    // Not divided by depth, so that corners may be behind the camera.
    vec3 barycentrics = edges_at(a, b, c, at);
    float sum = barycentrics.x + barycentrics.y + barycentrics.z;
    barycentrics = sum != 0.0 ? barycentrics / sum : vec3(1.0 / 3.0);
    uvec4 groups = corner_groups[index];
    vec3 normal = barycentrics.x * normal_of(groups.x) + barycentrics.y * normal_of(groups.y) + barycentrics.z * normal_of(groups.z);
    float length_of = length(normal);
    normal = length_of > 0.0 ? normal / length_of : vec3(0.0);
    // The side that is seen.
    normal = sum * params.winding > 0.0 ? -normal : normal;
    return tone_at(constants.frame, triangle, barycentrics, normal) * paint_at(constants.frame, index, triangle, barycentrics);
}

float line_near(ivec2 at) {
    return lines[index_of_sample(at)];
}
#include "ink_width.glsl"

vec4 sample_at(ivec2 at) {
    uint triangle_id = texelFetch(sampled, at, 0).x;
    if (triangle_id == 0u) {
        return vec4(0.0);
    }
    vec3 tone = tone_of(triangle_id - 1u, 0.5 * (vec2(at) + 0.5));
    float line = INKED != 0u ? line_of(at, REACH) : 0.0;
    return vec4(mix(tone, toon.ink_colour.rgb, line), 1.0);
}

void main() {
    ivec2 at = 2 * ivec2(pixel_of(gl_FragCoord.xy, uvec2(0u), params.size));
    // Four equal samples are the pixel, to the bit.
    vec4 above = sample_at(at) + sample_at(at + ivec2(1, 0));
    vec4 below = sample_at(at + ivec2(0, 1)) + sample_at(at + ivec2(1, 1));
    colour = 0.25 * (above + below);
}
