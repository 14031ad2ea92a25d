// The picture: of each pixel the mean of its four samples, each over what the frames show beside the mesh. What lies
// around the mesh in images, outlines, goes with it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "common/bits.glsl"
#include "samples.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
#include "seeing.glsl"
#include "fragment.glsl"
layout(binding = 18) uniform utexture2D distorted;
layout(binding = 19) uniform texture2D distorted_depth;
layout(binding = 20) uniform texture2D sampled_depth;
layout(std430, binding = 21) readonly buffer SampleColours { vec4 sample_colours[]; };
layout(std430, binding = 22) readonly buffer SampleStates { uint sample_states[]; };
layout(std430, binding = 23) writeonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 24) writeonly buffer ColourLayer { vec4 colour_layer[]; };
layout(binding = 25) uniform texture2D background_image;
layout(std430, binding = 27) readonly buffer Lines { float lines[]; };
#include "toon.glsl"
layout(constant_id = 0) const uint LAYERS = 0;  // 1: layers are kept
layout(constant_id = 1) const uint DEPTH = 0;   // 1: the host has a depth
layout(constant_id = 2) const uint CHOOSES = 0; // 1: one of two colours, 0: their mixture
layout(constant_id = 3) const uint INKED = 0;   // 1: ink is drawn here, over what has been distorted
layout(constant_id = 4) const int REACH = 1;    // samples from which a line can reach a sample
#include "mix.glsl"
#include "surface.glsl"
#include "background.glsl"

const float STEP = 0.98;  // share of its depth that what is before something else has at most

bool is_free(uint frame, uint cover) {
    return (cover & (MOVING | COVERED) << frame) == 0u;
}

float nearness_at(ivec2 at) {
    return texelFetch(sampled_depth, at, 0).x;
}

vec4 next_at(ivec2 pixel) {
    return texelFetch(frame_next, pixel, 0);
}

bool is_beside(ivec2 pixel) {
    return seen_at(2u, pixel) == 0u && is_empty(pixel);
}

// Whether frames are drawn by this effect, with all ink on the mesh.
bool is_drawn() {
    return params.is_drawn != 0u;
}

// Lines are known of what sees the mesh.
float line_near(ivec2 at) {
    uint index = index_of_sample(at);
    return (sample_states[index] & MASK) != NOTHING_SEEN ? lines[index] : 0.0;
}
#include "ink_width.glsl"

// Ink on a pixel's samples.
vec4 ink_of(ivec2 pixel) {
    vec4 ink = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ink[i] = INKED != 0u && is_drawn() ? line_of(sample_of(pixel, i), REACH) : 0.0;
    }
    return ink;
}

// A frame's pixel, finished.
vec4 finished_at(vec4 own, ivec2 pixel) {
    return params.is_over_background != 0u ? own + (1.0 - own.w) * background_at(pixel) : own;
}

// What goes along with the mesh around a pixel.
struct Skirt {
    Fragment fragment;  // of the nearest pixel that sees what moves
    vec2 centre;        // of that pixel
    float nearness;     // of what it sees; 0: there is none
};

Skirt skirt_of(ivec2 pixel, float farthest) {
    Skirt skirt;
    skirt.nearness = 0.0;
    float reach = params.skirt;
    int whole = is_drawn() ? -1 : int(reach);
    float nearest = reach * reach + 0.5;
    for (int y = -whole; y <= whole; ++y) {
        for (int x = -whole; x <= whole; ++x) {
            ivec2 other = pixel + ivec2(x, y);
            float way = float(x * x + y * y);
            if (!(way < nearest) || !is_in_picture(other)) {
                continue;
            }
            float nearness = texelFetch(distorted_depth, other, 0).x;
            if (!is_before(nearness, farthest, STEP)) {
                continue;
            }
            uint triangle_id = texelFetch(distorted, other, 0).x;
            if (triangle_id == 0u || is_still(triangles[finished[triangle_id - 1u].w & BASE_MASK])) {
                continue;
            }
            nearest = way;
            skirt.centre = vec2(other) + 0.5;
            skirt.nearness = nearness;
        }
    }
    if (skirt.nearness > 0.0) {
        uint triangle_id = texelFetch(distorted, ivec2(skirt.centre), 0).x;
        skirt.fragment = fragment_at(triangle_id, skirt.centre);
    }
    return skirt;
}

// What a frame has beside the mesh, as far from it as a place is now.
void look_beside(uint frame, Skirt skirt, vec2 place, out vec4 colour, out float weight) {
    vec3 barycentrics = skirt.fragment.barycentrics;
    vec3 own = barycentrics.x * corner_of(frame, skirt.fragment.base.x) + barycentrics.y * corner_of(frame, skirt.fragment.base.y)
        + barycentrics.z * corner_of(frame, skirt.fragment.base.z);
    colour = vec4(0.0);
    weight = 0.0;
    if (!(own.z >= params.near)) {
        return;
    }
    vec2 at = clamp(own.xy / widening(own.z) + (place - skirt.centre) - 0.5, vec2(-2.0), vec2(params.size) + 1.0);
    ivec2 corner = ivec2(floor(at));
    vec2 part = at - vec2(corner);
    for (int i = 0; i < 4; ++i) {
        ivec2 tap = corner + ivec2(i & 1, i >> 1);
        // What is as near as the mesh is the mesh, or hides it.
        if (!is_in_picture(tap) || !is_farther(depth_at(frame, tap), own.z, STEP)) {
            continue;
        }
        vec2 both = mix(1.0 - part, part, vec2(i & 1, i >> 1));
        float share = both.x * both.y;
        weight += share;
        if ((cover_at(tap) & COVERED << frame) != 0u) {
            colour += share * colour_at(frame, tap);
        }
    }
    colour = weight > 0.0 ? colour / weight : colour;
}

vec4 around(Skirt skirt, vec2 place) {
    vec4 colours[2];
    float weights[2];
    look_beside(1u, skirt, place, colours[0], weights[0]);
    look_beside(2u, skirt, place, colours[1], weights[1]);
    bool has_previous = weights[0] > LEAST_WEIGHT;
    bool has_next = weights[1] > LEAST_WEIGHT;
    return has_previous && has_next ? mixture(colours[0], colours[1], skirt.fragment.moved)
        : has_previous ? colours[0] : has_next ? colours[1] : vec4(0.0);
}

// How much of what lies around the mesh in an image is an outline of it, and not what is behind it: as much as it differs
// from what is seen without it.
float outline_share(vec4 beside, vec4 without) {
    vec4 apart = abs(beside - without);
    return clamp(4.0 * max(max(apart.x, apart.y), max(apart.z, apart.w)), 0.0, 1.0);
}

// How near the mesh is in frame i + 1 within reach of its outlines.
float nearest_beside(ivec2 pixel) {
    float nearest = 0.0;
    int reach = int(params.skirt);
    for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
            ivec2 other = pixel + ivec2(x, y);
            bool is_mesh = is_in_picture(other) && seen_at(2u, other) > 0u;
            nearest = is_mesh ? max(nearest, texelFetch(depth_next, other, 0).x) : nearest;
        }
    }
    return nearest;
}

void main() {
    ivec2 pixel = ivec2(tile_origin(gl_WorkGroupID) + gl_LocalInvocationID.xy);
    if (!is_in_picture(pixel)) {
        return;
    }
    vec4 ink = ink_of(pixel);
    uint cover = cover_at(pixel);
    float farthest = 1.0;
    float front = texelFetch(depth_next, pixel, 0).x;
    // What the host has drawn there.
    float scene_next = seen_at(2u, pixel) == 0u ? front : 0.0;
    float scene_previous = seen_at(1u, pixel) == 0u ? texelFetch(depth_previous, pixel, 0).x : 0.0;
    front -= scene_next;
    for (int i = 0; i < 4; ++i) {
        float nearness = nearness_at(sample_of(pixel, i));
        farthest = min(farthest, nearness);
        front = max(front, nearness);
    }
    bool is_next = is_free(2u, cover);
    // What is before the mesh is not behind it, and may have gone on.
    bool is_previous = !is_next && is_free(1u, cover);
    front = is_previous && scene_previous > 0.0 ? max(front, nearest_beside(pixel)) : front;
    is_previous = is_previous && !(front > 0.0 && scene_previous > front);
    vec4 behind = is_next ? finished_at(texelFetch(frame_next, pixel, 0), pixel)
        : is_previous ? finished_at(texelFetch(frame_previous, pixel, 0), pixel) : background_at(pixel);
    Skirt skirt = skirt_of(pixel, farthest);
    vec4 sum = vec4(0.0);
    vec4 of_mesh = vec4(0.0);
    bool is_behind = true;
    vec4 parts[4];       // of the mesh, with its outlines
    vec4 seen = vec4(0.0);  // how near they are
    float opaque = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 at = sample_of(pixel, i);
        uint index = index_of_sample(at);
        uint state = sample_states[index];
        float nearness = nearness_at(at);
        bool is_hidden = scene_next > nearness;
        bool is_seen = (state & MASK) != NOTHING_SEEN && !is_hidden;
        nearness = is_hidden ? 0.0 : nearness;
        vec4 colour = is_seen ? sample_colours[index] : vec4(0.0);
        // Without ink its colour is not there.
        if (INKED != 0u && ink[i] > 0.0) {
            colour.rgb = mix(colour.rgb, colour.w * toon.ink_colour.rgb, ink[i]);
        }
        bool is_part = is_seen && !(is_next && (state & STILL) != 0u);
        vec4 own = is_part ? colour + (1.0 - colour.w) * behind : behind;
        parts[i] = colour;
        seen[i] = nearness;
        if (is_before(skirt.nearness, max(nearness, scene_next), STEP)) {
            vec4 beside = around(skirt, 0.5 * (vec2(at) + 0.5));
            float share = outline_share(beside, own);
            parts[i] = share * beside + (1.0 - share * beside.w) * colour;
            seen[i] = share > 0.0 ? skirt.nearness : nearness;
            own = beside + (1.0 - beside.w) * own;
            colour = beside + (1.0 - beside.w) * colour;
            is_part = is_part || beside != vec4(0.0);
        }
        opaque += 0.25 * parts[i].w;
        is_behind = is_behind && !is_part;
        sum += 0.25 * own;
        of_mesh += 0.25 * colour;
    }
    uint index = index_of(pixel);
    vec4 own = is_behind ? behind : sum;
    // A negative sign of alpha: the pixel is frame i + 1's, which the target has already, unless it was drawn and may be hidden.
    bool is_there = DEPTH == 0u || !is_drawn();
    uint mark = is_behind && is_next && is_there ? SIGN_BIT : 0u;
    picture[index] = vec4(own.xyz, uintBitsToFloat(floatBitsToUint(own.w) & ~SIGN_BIT | mark));
    if (DEPTH == 1u) {
        float nearest = max(max(seen.x, seen.y), max(seen.z, seen.w));
        vec4 nearest_part = front_of(seen, nearest);
        vec4 covered = vec4(greaterThan(seen, vec4(0.0)));
        bool is_own = is_behind && is_next && nearest > 0.0;
        vec4 part = is_own ? dot(nearest_part, vec4(1.0)) / dot(covered, vec4(1.0)) * part_of_next(pixel, 0.25 * dot(covered, vec4(1.0)))
            : 0.25 * (nearest_part.x * parts[0] + nearest_part.y * parts[1] + nearest_part.z * parts[2] + nearest_part.w * parts[3]);
        // What the mesh has left is as far away as the mesh is there in frame i + 1, or what has been carried along.
        float farthest_seen = opaque > 0.9995 ? min(min(seen.x, seen.y), min(seen.z, seen.w)) : 0.0;
        float there = seen_at(2u, pixel) > 0u ? depth_at(2u, pixel) : INFINITY;
        float left = skirt.nearness > 0.0 ? depth_of(skirt.nearness) : there;
        covers(index, nearest > 0.0 ? part : vec4(0.0), nearest, nearest > 0.0 ? depth_of(farthest_seen) : left);
    }
    if (LAYERS == 1u) {
        colour_layer[index] = of_mesh;
    }
}
