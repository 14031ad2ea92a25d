// Counts the live and the visible spheres of each run of slots, and finds the depth range of the live ones and their
// bounds in light space.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
#include "view.glsl"
#include "list.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 2) writeonly buffer ListCounts { uvec2 list_counts[]; };
layout(std430, binding = 3) buffer ControlBuffer { Control control; };

shared uvec2 counted[256];
shared uint extremes[8];  // depth low, high; light-space low x, y, z, high x, y, z

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (lane < 8u) {
        extremes[lane] = lane == 0u || (lane >= 2u && lane < 5u) ? 0xffffffffu : 0u;
    }
    barrier();
    uint slot = gl_GlobalInvocationID.x;
    vec4 sphere = slot < params.counts.z ? spheres[slot] : vec4(0.0);
    bool live = is_live(sphere);
    counted[lane] = uvec2(live ? 1u : 0u, is_visible(sphere) ? 1u : 0u);
    if (live) {
        float depth = to_view(sphere.xyz).z;
        if (depth >= params.lens.z) {
            atomicMin(extremes[0], ordered(depth));
            atomicMax(extremes[1], ordered(depth));
        }
        vec3 at = vec3(dot(params.light_right.xyz, sphere.xyz), dot(params.light_up.xyz, sphere.xyz),
                       dot(params.light.xyz, sphere.xyz));
        for (int a = 0; a < 3; ++a) {
            atomicMin(extremes[2 + a], ordered(at[a] - sphere.w));
            atomicMax(extremes[5 + a], ordered(at[a] + sphere.w));
        }
    }
    for (uint width = 128u; width > 0u; width /= 2u) {
        barrier();
        if (lane < width) {
            counted[lane] += counted[lane + width];
        }
    }
    barrier();
    if (lane == 0u) {
        list_counts[gl_WorkGroupID.x] = counted[0];
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
