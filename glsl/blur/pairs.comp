// Places that both frames show, evenly over what moves in either: at one pixel in so many along each axis that there are
// not too many.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "samples.glsl"
#include "tones.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
#include "seeing.glsl"
layout(std430, binding = 18) readonly buffer CornerGroups { uvec4 corner_groups[]; };
layout(std430, binding = 19) readonly buffer Normals { vec4 normals[]; };
layout(std430, binding = 20) buffer Completing { uint completing[]; };
layout(std430, binding = 21) writeonly buffer Sites { Site sites[]; };
layout(constant_id = 0) const uint GROUPS = 0;
#include "tables.glsl"
#include "lesson.glsl"
#include "common/random.glsl"

int change_of(float from, float to) {
    float logarithm = log(lit(to)) - log(lit(from));
    return clamp(int(floor(logarithm * LOGARITHM + 0.5)), -MOST_CHANGE, MOST_CHANGE);
}

void main() {
    uint stride = 1u;
    while (stride < MOST_STRIDE && stride * stride * WANTED_SITES < completing[MOVING_COUNT]) {
        stride += 1u;
    }
    ivec2 at = ivec2(tile_origin(gl_WorkGroupID) + gl_LocalInvocationID.xy);
    uvec2 cell = uvec2(at) / stride;
    bool is_one = uvec2(at) == cell * stride + stride / 2u;
    uint frame = gl_GlobalInvocationID.z;
    Lesson lesson = lesson_of(1u + frame, at);
    if (!is_one || !lesson.is_there || (cover_at(at) & MOVING << (1u + frame)) == 0u) {
        return;
    }
    Site site;
    vec4 colours[2];
    float weight;
    look(2u - frame, lesson.base, lesson.barycentrics, colours[1u - frame], weight);
    colours[frame] = colour_at(1u + frame, at);
    for (uint k = 0u; k < 2u; ++k) {
        vec3 normal = unit(normal_at(k, lesson.place, lesson.base, lesson.barycentrics));
        weight = normal == vec3(0.0) ? 0.0 : weight;
        site.normals[k] = vec4(normal, 0.0);
    }
    if (!(weight > LEAST_WEIGHT)) {
        return;
    }
    uint surface = surface_of(lesson.base.w);
    site.normals[0].w = float(surface);
    for (uint i = 0u; i < 3u; ++i) {
        site.change[i] = change_of(colours[0][i], colours[1][i]);
    }
    site.change.w = 1;
    if (surface < params.tables) {
        atomicAdd(completing[SURFACES + 2u * surface], 1u);
    }
    uint index = atomicAdd(completing[SITE_COUNT], 1u);
    if (index < MOST_SITES) {
        sites[index] = site;
    }
    bool is_clear = sum_of(site.change.xyz) >= CLEAR;
    if (is_clear || ((cell.x & 3u) == 0u && (cell.y & 1u) == 0u)) {
        site.change.w = is_clear ? 1 : int(FEW_WEIGHT);
        uint few = atomicAdd(completing[FEW_COUNT], 1u);
        if (few < MOST_FEW) {
            sites[MOST_SITES + few] = site;
        }
        uint parts = max(completing[MOVING_COUNT] / (stride * stride * WANTED_FIRST), 1u);
        if (hash(frame, cell.x, cell.y, 0u) % parts == 0u) {
            uint first = atomicAdd(completing[FIRST_COUNT], 1u);
            if (first < MOST_FIRST) {
                sites[MOST_SITES + MOST_FEW + first] = site;
            }
        }
    }
}
