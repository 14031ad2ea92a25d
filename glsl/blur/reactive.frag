// The share of each pixel that shows what is smeared, of four samples.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
layout(constant_id = 0) const uint DEPTH = 0;  // 1: the host has a depth
#include "params.glsl"
#include "../common/host_depth.glsl"
#include "common/fragment.glsl"
layout(std430, binding = 1) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 2) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 3) readonly buffer Triangles { uvec4 triangles[]; };
#include "base.glsl"
#include "visible.glsl"
layout(location = 0) out float share;

void main() {
    ivec2 pixel = ivec2(pixel_of(gl_FragCoord.xy, params.corner, params.size));
    share = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 at = sample_of(pixel, i);
        if (shown_nearness(pixel, at) > 0.0) {
            uint base = finished[texelFetch(sampled, at, 0).x - 1u].w & BASE_MASK;
            share += is_still(triangles[base]) ? 0.0 : 0.25;
        }
    }
    if (share == 0.0) {
        discard;
    }
    gl_FragDepth = DEPTH == 1u ? host_depth(drawn_depth_of(pixel)) : 0.0;
}
