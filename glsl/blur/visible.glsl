// Which of a pixel's four samples show the distorted mesh: those that see it where the host has drawn nothing nearer in frame i + 1.
#include "depths.glsl"
#include "picture.glsl"
layout(binding = 4) uniform utexture2D sampled;
layout(binding = 5) uniform texture2D sampled_depth;
layout(binding = 6) uniform utexture2D seen_next;
layout(binding = 7) uniform texture2D depth_next;
layout(std430, binding = 8) readonly buffer Surface { Covering surface[]; };

// How near the mesh is in a sample; 0 where it is not shown.
float shown_nearness(ivec2 pixel, ivec2 at) {
    float scene = texelFetch(seen_next, pixel, 0).x == 0u ? texelFetch(depth_next, pixel, 0).x : 0.0;
    float own = texelFetch(sampled_depth, at, 0).x;
    return scene > own ? 0.0 : own;
}

// The depth at which the composite draws a pixel.
float drawn_depth_of(ivec2 pixel) {
    Covering own = surface[index_of(pixel)];
    return isinf(own.behind) ? own.depth : own.behind;
}
