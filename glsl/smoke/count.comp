// Counts the live and the visible spheres of each block of slots, and finds the depth range of the live ones and their
// bounds in light space. Puts them into view space for all that follows.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
#include "view.glsl"
#include "list.glsl"
#include "light_space.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 2) writeonly buffer ListSums { uvec2 block_sums[]; };
layout(std430, binding = 3) buffer ControlBuffer { Control control; };
layout(std430, binding = 4) writeonly buffer ViewSpheres { vec4 view_spheres[]; };

#define SCAN_TYPE uvec2
#include "common/scan.glsl"

shared uint extremes[8];  // depth low, high; light-space low x, y, z, high x, y, z

void measure(vec4 sphere, float depth) {
    if (depth >= params.near) {
        atomicMin(extremes[0], ordered(depth));
        atomicMax(extremes[1], ordered(depth));
    }
    vec3 at = in_light_space(sphere.xyz);
    for (int a = 0; a < 3; ++a) {
        atomicMin(extremes[2 + a], ordered(at[a] - sphere.w));
        atomicMax(extremes[5 + a], ordered(at[a] + sphere.w));
    }
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (lane < 8u) {
        extremes[lane] = lane == 0u || (lane >= 2u && lane < 5u) ? 0xffffffffu : 0u;
    }
    barrier();
    uint first = gl_GlobalInvocationID.x * LIST_RUN;
    uvec2 count = uvec2(0u);
    for (uint slot = first; slot < min(first + LIST_RUN, params.spheres); ++slot) {
        vec4 sphere = spheres[slot];
        if (is_live(sphere)) {
            vec3 centre = to_view(sphere.xyz);
            vec4 view_sphere = vec4(centre, drawn_radius(sphere.w, centre.z));
            view_spheres[slot] = view_sphere;
            count += uvec2(1u, is_visible(view_sphere) ? 1u : 0u);
            measure(sphere, view_sphere.z);
        }
    }
    uvec2 all = scan_workgroup(count).all;
    if (lane == 0u) {
        block_sums[gl_WorkGroupID.x] = all;
        atomicMin(control.depth_low, extremes[0]);
        atomicMax(control.depth_high, extremes[1]);
        atomicMin(control.light_low_x, extremes[2]);
        atomicMin(control.light_low_y, extremes[3]);
        atomicMin(control.light_low_z, extremes[4]);
        atomicMax(control.light_high_x, extremes[5]);
        atomicMax(control.light_high_y, extremes[6]);
        atomicMax(control.light_high_z, extremes[7]);
    }
}
