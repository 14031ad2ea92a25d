// The picture: of each pixel the mean of its four samples, each over what the frames show beside the mesh. What lies
// around the mesh in the frames, outlines, goes with it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "samples.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
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
layout(constant_id = 0) const uint LAYERS = 0;  // 1: layers are kept

#include "background.glsl"

const float STEP = 0.98;  // share of its depth that what is before something else has at most

bool is_free(uint frame, uint cover) {
    return (cover & (MOVING | COVERED) << frame) == 0u;
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
    float reach = uintBitsToFloat(params.completion.z);
    int whole = int(reach);
    float nearest = reach * reach + 0.5;
    for (int y = -whole; y <= whole; ++y) {
        for (int x = -whole; x <= whole; ++x) {
            ivec2 other = pixel + ivec2(x, y);
            float way = float(x * x + y * y);
            if (!(way < nearest) || !is_in_picture(other)) {
                continue;
            }
            float nearness = texelFetch(distorted_depth, other, 0).x;
            if (!(nearness * STEP > farthest)) {
                continue;
            }
            uint name = texelFetch(distorted, other, 0).x;
            if (name == 0u || is_still(triangles[finished[name - 1u].w & BASE_MASK])) {
                continue;
            }
            nearest = way;
            skirt.centre = vec2(other) + 0.5;
            skirt.nearness = nearness;
        }
    }
    if (skirt.nearness > 0.0) {
        uint name = texelFetch(distorted, ivec2(skirt.centre), 0).x;
        skirt.fragment = fragment_at(name, skirt.centre);
    }
    return skirt;
}

// What a frame has beside the mesh, as far from it as a place is now.
void look_beside(uint frame, Skirt skirt, vec2 place, out vec4 colour, out float weight) {
    vec3 shares = skirt.fragment.shares;
    vec3 own = shares.x * corner_of(frame, skirt.fragment.base.x) + shares.y * corner_of(frame, skirt.fragment.base.y)
        + shares.z * corner_of(frame, skirt.fragment.base.z);
    colour = vec4(0.0);
    weight = 0.0;
    if (!(own.z >= params.lens.x)) {
        return;
    }
    vec2 at = clamp(own.xy / own.z + (place - skirt.centre) - 0.5, vec2(-2.0), vec2(params.image.xy) + 1.0);
    ivec2 corner = ivec2(floor(at));
    vec2 part = at - vec2(corner);
    for (int i = 0; i < 4; ++i) {
        ivec2 tap = corner + ivec2(i & 1, i >> 1);
        // What is as near as the mesh is the mesh, or hides it.
        if (!is_in_picture(tap) || depth_at(frame, tap) * STEP <= own.z) {
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
    float later = clamp(skirt.fragment.moved, 0.0, 1.0);
    return has_previous && has_next ? mix(colours[0], colours[1], later)
        : has_previous ? colours[0] : has_next ? colours[1] : vec4(0.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!is_in_picture(pixel)) {
        return;
    }
    uint cover = cover_at(pixel);
    bool is_next = is_free(2u, cover);
    vec4 behind = is_next ? texelFetch(frame_next, pixel, 0)
        : is_free(1u, cover) ? texelFetch(frame_previous, pixel, 0) : background_at(pixel);
    float farthest = 1.0;
    for (int i = 0; i < 4; ++i) {
        farthest = min(farthest, texelFetch(sampled_depth, 2 * pixel + ivec2(i & 1, i >> 1), 0).x);
    }
    Skirt skirt = skirt_of(pixel, farthest);
    vec4 sum = vec4(0.0);
    vec4 of_mesh = vec4(0.0);
    bool is_behind = true;
    for (int i = 0; i < 4; ++i) {
        ivec2 at = 2 * pixel + ivec2(i & 1, i >> 1);
        uint index = uint(at.y) * 2u * params.image.x + uint(at.x);
        uint state = sample_states[index];
        vec4 colour = (state & MASK) == 4u ? vec4(0.0) : sample_colours[index];
        bool is_part = (state & MASK) != 4u && !(is_next && (state & STILL) != 0u);
        vec4 own = is_part ? colour + (1.0 - colour.w) * behind : behind;
        if (skirt.nearness * STEP > texelFetch(sampled_depth, at, 0).x) {
            vec4 beside = around(skirt, 0.5 * (vec2(at) + 0.5));
            own = beside + (1.0 - beside.w) * own;
            colour = beside + (1.0 - beside.w) * colour;
            is_part = is_part || beside != vec4(0.0);
        }
        is_behind = is_behind && !is_part;
        sum += 0.25 * own;
        of_mesh += 0.25 * colour;
    }
    // An alpha below 0: the pixel is frame i + 1's, which the target has already.
    uint index = uint(pixel.y) * params.image.x + uint(pixel.x);
    picture[index] = !is_behind ? sum : is_next ? vec4(behind.xyz, -1.0) : behind;
    if (LAYERS == 1u) {
        colour_layer[index] = of_mesh;
    }
}
