// For each block of pixels a depth behind which nothing can be seen: the farthest of a sphere's front over a block that
// it covers whole. Seen from the eye, 1 / depth of a ball's front is a concave function of the pixel, so the farthest is at
// a corner of the block.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "view.glsl"
#include "bounds.glsl"
layout(local_size_x = LIVE_LANES) in;
layout(std430, binding = 1) readonly buffer ViewSpheres { vec4 view_spheres[]; };
layout(std430, binding = 2) readonly buffer Live { uint live_list[]; };
layout(std430, binding = 3) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 4) buffer Occlusion { uint occlusion[]; };

// Depth of the front at a corner; infinite if the ray passes by.
float corner_depth(vec2 corner, vec4 view_sphere) {
    float depth;
    vec3 normal;
    return hit_sphere(pixel_ray(corner), view_sphere, depth, normal) ? depth : INFINITY;
}

void main() {
    if (gl_GlobalInvocationID.x >= control.live) {
        return;
    }
    vec4 sphere = view_spheres[live_list[gl_GlobalInvocationID.x]];
    if (!is_bounded(sphere) || sphere.z - sphere.w < params.near) {
        return;
    }
    vec4 bounds = pixel_bounds(sphere);
    float side = float(params.occlusion_side);
    ivec2 first = ivec2(clamp(ceil(bounds.xy / side), vec2(0.0), vec2(params.occlusion_blocks)));
    ivec2 last = ivec2(clamp(floor(bounds.zw / side), vec2(0.0), vec2(params.occlusion_blocks)));
    for (int y = first.y; y < last.y; ++y) {
        for (int x = first.x; x < last.x; ++x) {
            vec2 low = vec2(x, y) * side;
            float depth = max(max(corner_depth(low, sphere), corner_depth(low + vec2(side, 0.0), sphere)),
                              max(corner_depth(low + vec2(0.0, side), sphere), corner_depth(low + side, sphere)));
            if (depth <= params.far) {
                // A little farther, for rounding.
                atomicMin(occlusion[uint(y) * params.occlusion_blocks.x + uint(x)], floatBitsToUint(depth * 1.0001));
            }
        }
    }
}
