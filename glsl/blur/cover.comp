// What pixels of frames i and i + 1 may show besides what they see: outlines that lie outside of what they belong to. And
// how bright the images are.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "common/bits.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
layout(binding = 1) uniform utexture2D seen_previous;
layout(binding = 2) uniform utexture2D seen_next;
layout(binding = 3) uniform texture2D depth_previous;
layout(binding = 4) uniform texture2D depth_next;
layout(binding = 5) uniform texture2D frame_previous;
layout(binding = 6) uniform texture2D frame_next;
layout(std430, binding = 7) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 8) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 9) buffer Tiles { uint tiles[]; };
#include "tiles.glsl"
#include "base.glsl"
layout(std430, binding = 10) buffer Completing { uint completing[]; };
#include "samples.glsl"

layout(std430, binding = 11) readonly buffer Clip { vec4 clip[]; };
#include "edges.glsl"
#include "depths.glsl"

// What of the mesh is before something else is nearer than this would be there if it went on as it does: by this share of its depth,
// and as much as a surface turned away by 63 degrees is within the way.
const float LEAST_STEP = 0.003;
const float LEAST_SLOPE = 2.0;
shared uint most[3];
shared uint moving;

bool is_moving(uint seen) {
    return !is_still(triangles[seen - 1u]);
}

uint seen_at(uint frame, ivec2 at) {
    return frame == 1u ? texelFetch(seen_previous, at, 0).x : texelFetch(seen_next, at, 0).x;
}

// As it is kept: larger is nearer, 0 is nothing.
float nearness(uint frame, ivec2 at) {
    return frame == 1u ? texelFetch(depth_previous, at, 0).x : texelFetch(depth_next, at, 0).x;
}

uint shown_at(uint frame, ivec2 at) {
    uint seen = seen_at(frame, at);
    uint result = seen > 0u && is_moving(seen) ? MOVING : 0u;
    uvec4 base = triangles[max(seen, 1u) - 1u];
    uint first = frame * params.points;
    vec3 a = clip[first + base.x].xyz;
    vec3 b = clip[first + base.y].xyz;
    vec3 c = clip[first + base.z].xyz;
    float focal = params.views[frame].eye.w;
    float scene = nearness(frame, at);
    float skirt = params.skirt;
    int reach = int(skirt);
    for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
            ivec2 other = at + ivec2(x, y);
            bool is_near = float(x * x + y * y) <= skirt * skirt && is_in_picture(other);
            vec3 edges = edges_at(a, b, c, vec2(other) + 0.5);
            float own = seen > 0u ? nearness_of_plane(edges, vec3(a.z, b.z, c.z)) : scene;
            float least = 1.0 - LEAST_STEP - LEAST_SLOPE * length(vec2(x, y)) / focal;
            bool is_mesh = seen_at(frame, other) > 0u;
            if (is_near && is_mesh && is_before(nearness(frame, other), own, least)) {
                result |= is_moving(seen_at(frame, other)) ? OUTLINE | COVERED : OUTLINE;
            }
        }
    }
    return result << frame;
}

void measure(vec4 colour, uint frame) {
    float brightest = max(max(colour.x, colour.y), colour.z);
    float infinite = INFINITY;
    for (uint i = 0u; i < 4u; ++i) {
        // What is not a number or below 1 is not above it.
        if (colour[i] > 1.0 && colour[i] < infinite) {
            atomicMax(most[frame], floatBitsToUint(colour[i]));
        }
    }
    if (colour.w > 0.0 && brightest / colour.w > 1.0 && brightest / colour.w < infinite) {
        atomicMax(most[2], floatBitsToUint(brightest / colour.w));
    }
}

void main() {
    ivec2 at = ivec2(tile_origin(gl_WorkGroupID) + gl_LocalInvocationID.xy);
    bool is_inside = all(lessThan(at, ivec2(params.size)));
    uint lane = gl_LocalInvocationIndex;
    if (lane < 3u) {
        most[lane] = 0u;
    }
    if (lane == 0u) {
        moving = 0u;
    }
    barrier();
    if (is_inside) {
        uint covers = shown_at(1u, at) | shown_at(2u, at);
        tiles[cover_of(at)] = covers;
        atomicAdd(moving, bitCount(covers & (MOVING << 1u | MOVING << 2u)));
        // Nothing but the mesh is looked at.
        measure(seen_at(1u, at) > 0u ? texelFetch(frame_previous, at, 0) : vec4(0.0), 0u);
        measure(seen_at(2u, at) > 0u ? texelFetch(frame_next, at, 0) : vec4(0.0), 1u);
    }
    barrier();
    if (lane < 3u && most[lane] > 0u) {
        atomicMax(completing[SCALES + lane], most[lane]);
    }
    if (lane == 0u && moving > 0u) {
        atomicAdd(completing[MOVING_COUNT], moving);
    }
}
