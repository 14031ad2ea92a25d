// Triangle-id buffers as layers, for reading after the frame.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "picture.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
layout(binding = 1) uniform utexture2D seen_previous;
layout(binding = 2) uniform utexture2D seen_next;
layout(binding = 3) uniform utexture2D distorted;
layout(std430, binding = 4) writeonly buffer PreviousNames { uint previous_names[]; };
layout(std430, binding = 5) writeonly buffer NextNames { uint next_names[]; };
layout(std430, binding = 6) writeonly buffer DistortedNames { uint distorted_names[]; };

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, ivec2(params.size)))) {
        return;
    }
    uint pixel = index_of(at);
    previous_names[pixel] = texelFetch(seen_previous, at, 0).x;
    next_names[pixel] = texelFetch(seen_next, at, 0).x;
    distorted_names[pixel] = texelFetch(distorted, at, 0).x;
}
