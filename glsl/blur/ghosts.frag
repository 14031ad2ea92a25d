// What an after-image's sample shows: the colours of its surface in frames i and i + 1.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/half.glsl"
#include "params.glsl"
#include "common/widening.glsl"
#include "picture.glsl"
#include "triangle_word.glsl"
layout(std430, binding = 3) readonly buffer Triangles { uvec4 triangles[]; };
layout(binding = 6) uniform utexture2D seen_previous;
layout(binding = 7) uniform utexture2D seen_next;
layout(binding = 8) uniform texture2D frame_previous;
layout(binding = 9) uniform texture2D frame_next;
layout(location = 0) in vec3 previous;
layout(location = 1) in vec3 next;
layout(location = 2) in float moved;
layout(location = 3) flat in uint surface;
layout(location = 0) out vec4 colour;

// The pixel that sees a place; outside of the picture there is none.
bool find(vec3 place, out ivec2 at) {
    vec2 pixel = clamp(place.xy / widening(place.z), vec2(-1.0), vec2(params.size) + 1.0);
    at = ivec2(floor(pixel));
    return place.z > params.near && is_in_picture(at);
}

void main() {
    ivec2 before;
    ivec2 after;
    uint seen = find(previous, before) ? texelFetch(seen_previous, before, 0).x : 0u;
    bool has_previous = seen != 0u && surface_of(triangles[max(seen, 1u) - 1u].w) == surface;
    seen = find(next, after) ? texelFetch(seen_next, after, 0).x : 0u;
    bool has_next = seen != 0u && surface_of(triangles[max(seen, 1u) - 1u].w) == surface;
    if (!has_previous && !has_next) {
        discard;
    }
    vec4 earlier = texelFetch(frame_previous, has_previous ? before : ivec2(0), 0);
    vec4 later = texelFetch(frame_next, has_next ? after : ivec2(0), 0);
    colour = has_previous && has_next ? mix(earlier, later, clamp(moved, 0.0, 1.0)) : has_previous ? earlier : later;
    // The image is in half precision: what is beyond its largest number would be infinite.
    colour = clamp(colour, vec4(-MOST_HALF), vec4(MOST_HALF));
}
