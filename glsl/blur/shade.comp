// What pixels of the distorted mesh look like: colours from where its surface is in frames i and i + 1, at four samples a
// pixel. What is not the mesh's is what the frames show beside it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1) uniform utexture2D seen_previous;
layout(binding = 2) uniform utexture2D seen_next;
layout(binding = 3) uniform utexture2D distorted;
layout(binding = 4) uniform utexture2D sampled;
layout(binding = 5) uniform texture2D depth_previous;
layout(binding = 6) uniform texture2D depth_next;
layout(binding = 7) uniform texture2D frame_previous;
layout(binding = 8) uniform texture2D frame_next;
layout(std430, binding = 9) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 10) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 11) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 12) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 13) writeonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 14) writeonly buffer ColourLayer { vec4 colour_layer[]; };
layout(std430, binding = 15) writeonly buffer PreviousLayer { vec4 previous_layer[]; };
layout(std430, binding = 16) writeonly buffer NextLayer { vec4 next_layer[]; };
layout(std430, binding = 17) writeonly buffer SubframeLayer { float subframe_layer[]; };
layout(std430, binding = 18) writeonly buffer MaskLayer { uint mask_layer[]; };
layout(constant_id = 0) const uint LAYERS = 0;  // 1: layers are kept

const float SAME_DEPTH = 0.003;  // share of its depth by which a surface may be off and still be the same
const uint NEITHER = 0u;
const uint PREVIOUS = 1u;
const uint NEXT = 2u;
const uint BACKGROUND = 4u;

// What a sample shows.
struct Sample {
    vec4 colour;
    vec4 previous;  // what frame i has of it
    vec4 next;
    float moved;    // k'
    uint mask;      // PREVIOUS and NEXT where these show it
    bool is_next;   // it is frame i + 1's own pixel
};

float cross2(vec2 a, vec2 b) {
    return a.x * b.y - a.y * b.x;
}

// Shares of a triangle's corners (pixels and view depth) in what is seen at a place; they need not be within it.
vec3 shares_of(vec3 a, vec3 b, vec3 c, vec2 at) {
    vec2 p = a.xy - at;
    vec2 q = b.xy - at;
    vec2 r = c.xy - at;
    vec3 shares = vec3(cross2(q, r) / a.z, cross2(r, p) / b.z, cross2(p, q) / c.z);
    float sum = shares.x + shares.y + shares.z;
    return sum != 0.0 ? shares / sum : vec3(1.0 / 3.0);
}

// The colour that a frame shows of a place of a base triangle; w of the result's second part: how much of it can be seen.
void look(uint frame, uvec4 triangle, vec3 shares, out vec4 colour, out float weight) {
    uint first = frame * params.counts.x;
    vec3 a = clip[first + triangle.x].xyz;
    vec3 b = clip[first + triangle.y].xyz;
    vec3 c = clip[first + triangle.z].xyz;
    vec3 own = shares.x * a + shares.y * b + shares.z * c;
    colour = vec4(0.0);
    weight = 0.0;
    if (!(own.z > params.lens.x)) {
        return;
    }
    // A place far outside of the picture has no taps, and no whole numbers either.
    vec2 at = clamp(own.xy / own.z - 0.5, vec2(-2.0), vec2(params.image.xy) + 1.0);
    ivec2 corner = ivec2(floor(at));
    vec2 part = at - vec2(corner);
    bool in_front = min(min(a.z, b.z), c.z) > params.lens.x;
    vec3 pa = vec3(a.xy / a.z, a.z);
    vec3 pb = vec3(b.xy / b.z, b.z);
    vec3 pc = vec3(c.xy / c.z, c.z);
    for (int i = 0; i < 4; ++i) {
        ivec2 tap = corner + ivec2(i & 1, i >> 1);
        if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, ivec2(params.image.xy)))) {
            continue;
        }
        uint seen = frame == 1u ? texelFetch(seen_previous, tap, 0).x : texelFetch(seen_next, tap, 0).x;
        if (seen == 0u || triangles[seen - 1u].w >> 1 != triangle.w >> 1) {
            continue;
        }
        float depth = params.lens.x / (frame == 1u ? texelFetch(depth_previous, tap, 0).x : texelFetch(depth_next, tap, 0).x);
        // The triangle's plane goes on beyond it, which is the surface's slope; where it is seen from its edge it is none.
        float plane = own.z;
        if (in_front) {
            vec3 there = shares_of(pa, pb, pc, vec2(tap) + 0.5);
            plane = there.x * a.z + there.y * b.z + there.z * c.z;
        }
        if (!(min(abs(depth - own.z), abs(depth - plane)) <= SAME_DEPTH * own.z)) {
            continue;
        }
        vec2 both = mix(1.0 - part, part, vec2(i & 1, i >> 1));
        float share = both.x * both.y;
        colour += share * (frame == 1u ? texelFetch(frame_previous, tap, 0) : texelFetch(frame_next, tap, 0));
        weight += share;
    }
    colour = weight > 0.0 ? colour / weight : colour;
}

// What is where the distorted mesh is not: what the later frame shows beside the mesh, else the earlier one.
Sample beside(ivec2 pixel) {
    vec4 next = texelFetch(frame_next, pixel, 0);
    if (texelFetch(seen_next, pixel, 0).x == 0u) {
        return Sample(next, vec4(0.0), next, 1.0, BACKGROUND, true);
    }
    vec4 previous = texelFetch(frame_previous, pixel, 0);
    if (texelFetch(seen_previous, pixel, 0).x == 0u) {
        return Sample(previous, previous, vec4(0.0), 0.0, BACKGROUND, false);
    }
    return Sample(params.background, vec4(0.0), vec4(0.0), 0.0, BACKGROUND, false);
}

Sample shade(uint name, vec2 at, ivec2 pixel) {
    if (name == 0u) {
        return beside(pixel);
    }
    uvec4 triangle = finished[name - 1u];
    uvec4 base = triangles[triangle.w & BASE_MASK];
    vec4 drawn[3];
    vec2 places[3];
    for (uint corner = 0u; corner < 3u; ++corner) {
        Vertex vertex = vertices[triangle[corner]];
        drawn[corner] = vertex.drawn;
        places[corner] = vertex.place.y == 0u ? uintBitsToFloat(vertex.place.zw)
            : vec2(base.y == triangle[corner] ? 1.0 : 0.0, base.z == triangle[corner] ? 1.0 : 0.0);
    }
    if (drawn[0].w == 1.0 && drawn[1].w == 1.0 && drawn[2].w == 1.0) {
        vec4 next = texelFetch(frame_next, pixel, 0);
        return Sample(next, vec4(0.0), next, 1.0, NEXT, true);
    }
    vec3 within = shares_of(drawn[0].xyz, drawn[1].xyz, drawn[2].xyz, at);
    vec2 place = within.x * places[0] + within.y * places[1] + within.z * places[2];
    float moved = within.x * drawn[0].w + within.y * drawn[1].w + within.z * drawn[2].w;
    vec3 shares = vec3(1.0 - place.x - place.y, place);
    Sample result;
    float of_previous;
    float of_next;
    look(1u, base, shares, result.previous, of_previous);
    look(2u, base, shares, result.next, of_next);
    float later = clamp(moved, 0.0, 1.0);
    result.moved = moved;
    result.is_next = false;
    result.mask = (of_previous > 0.25 ? PREVIOUS : 0u) | (of_next > 0.25 ? NEXT : 0u);
    // Where neither can be seen, what can be least badly is better than nothing.
    bool has_previous = result.mask == NEITHER ? of_previous > 0.0 : (result.mask & PREVIOUS) != 0u;
    bool has_next = result.mask == NEITHER ? of_next > 0.0 : (result.mask & NEXT) != 0u;
    result.colour = has_previous && has_next ? mix(result.previous, result.next, later)
        : has_previous ? result.previous : has_next ? result.next : texelFetch(frame_next, pixel, 0);
    return result;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(params.image.xy)))) {
        return;
    }
    uint index = uint(pixel.y) * params.image.x + uint(pixel.x);
    vec4 sum = vec4(0.0);
    vec4 of_mesh = vec4(0.0);
    bool is_next = true;
    for (int i = 0; i < 4; ++i) {
        ivec2 half_pixel = 2 * pixel + ivec2(i & 1, i >> 1);
        Sample at = shade(texelFetch(sampled, half_pixel, 0).x, 0.5 * (vec2(half_pixel) + 0.5), pixel);
        sum += 0.25 * at.colour;
        of_mesh += at.mask == BACKGROUND ? vec4(0.0) : 0.25 * at.colour;
        is_next = is_next && at.is_next;
    }
    // An alpha below 0: the pixel is frame i + 1's, which the target has already.
    picture[index] = is_next ? vec4(texelFetch(frame_next, pixel, 0).xyz, -1.0) : sum;
    if (LAYERS == 1u) {
        Sample at = shade(texelFetch(distorted, pixel, 0).x, vec2(pixel) + 0.5, pixel);
        colour_layer[index] = of_mesh;
        previous_layer[index] = (at.mask & PREVIOUS) != 0u ? at.previous : vec4(0.0);
        next_layer[index] = (at.mask & NEXT) != 0u ? at.next : vec4(0.0);
        subframe_layer[index] = at.moved;
        mask_layer[index] = at.mask;
    }
}
