// Strength of the ink line of the distorted mesh at each of four samples a pixel, before its width.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "depths.glsl"
#include "toon.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
layout(binding = 1) uniform utexture2D sampled;
layout(binding = 2) uniform texture2D sampled_depth;
layout(std430, binding = 3) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 4) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 5) readonly buffer Tiles { uint tiles[]; };
layout(std430, binding = 6) writeonly buffer Lines { float lines[]; };
#include "tiles.glsl"
#include "edges.glsl"
#include "fragment.glsl"
#include "dry.glsl"
layout(constant_id = 2) const float INK_DRY = 0.0;  // the setting `dry`

const uint SEEN_SIDE = TILE + 2u;  // samples that a workgroup looks at, in a row

shared uint names[SEEN_SIDE * SEEN_SIDE];
shared float depths[SEEN_SIDE * SEEN_SIDE];
shared vec3 places[SEEN_SIDE * SEEN_SIDE];

uvec2 first_sample() {
    uvec2 part = TILE * uvec2(gl_WorkGroupID.z & 1u, gl_WorkGroupID.z >> 1);
    return 2u * tile_origin(gl_WorkGroupID) + part;
}

uint cell_of(ivec2 at) {
    uvec2 cell = uvec2(at - ivec2(first_sample()) + 1);
    return cell.y * SEEN_SIDE + cell.x;
}

uint name_at(ivec2 at) {
    return names[cell_of(at)];
}

uint object_of(uint name) {
    return triangles[finished[name - 1u].w & BASE_MASK].w >> OBJECT_SHIFT;
}

float depth_of_sample(ivec2 at) {
    return depths[cell_of(at)];
}

vec3 place_of_sample(ivec2 at) {
    return places[cell_of(at)];
}
#include "ink_line.glsl"

// Where frame i + 1 has what a sample sees.
vec3 place_in_frame(uint name, ivec2 at) {
    Fragment fragment = fragment_at(name, 0.5 * (vec2(at) + 0.5));
    uint first = 2u * params.points;
    vec3 place = fragment.barycentrics.x * clip[first + fragment.base.x].xyz + fragment.barycentrics.y * clip[first + fragment.base.y].xyz
        + fragment.barycentrics.z * clip[first + fragment.base.z].xyz;
    return vec3(2.0 * place.xy / widening(place.z), place.z);
}

// Whether a sample is where bristles end: there is no line around each of these.
bool is_dry(ivec2 at) {
    uint name = name_at(at);
    if (INK_DRY == 0.0 || name == 0u) {
        return false;
    }
    Fragment fragment = fragment_at(name, 0.5 * (vec2(at) + 0.5));
    vec2 extent = vec2(0.0);
    for (uint corner = 0u; corner < 3u; ++corner) {
        extent += fragment.inside[corner] * ends_of(vertices[fragment.corners[corner]]);
    }
    return extent.x < longest_dry(INK_DRY, extent.y);
}

void see(uint cell) {
    ivec2 at = ivec2(first_sample()) + ivec2(cell % SEEN_SIDE, cell / SEEN_SIDE) - 1;
    bool is_inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, 2 * ivec2(params.size)));
    uint name = is_inside ? texelFetch(sampled, at, 0).x : 0u;
    names[cell] = name;
    depths[cell] = is_inside ? depth_of(texelFetch(sampled_depth, at, 0).x) : INFINITY;
    places[cell] = name != 0u && BY_STEPS != 0u ? place_in_frame(name, at) : vec3(0.0);
}

void main() {
    for (uint cell = gl_LocalInvocationIndex; cell < SEEN_SIDE * SEEN_SIDE; cell += TILE * TILE) {
        see(cell);
    }
    barrier();
    ivec2 at = ivec2(first_sample() + gl_LocalInvocationID.xy);
    if (all(lessThan(at, 2 * ivec2(params.size)))) {
        lines[index_of_sample(at)] = is_dry(at) ? 0.0 : line_at(at);
    }
}
