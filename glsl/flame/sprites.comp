// The list of all render particles of a repetition, in one workgroup: what the paper's way draws.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 3) writeonly buffer SpriteList { uvec2 sprite_list[]; };

shared uint sums[gl_WorkGroupSize.x];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint share = (params.particle_count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint first = min(lane * share, params.particle_count);
    uint last = min(first + share, params.particle_count);
    uint sum = 0u;
    for (uint row = first; row < last; ++row) {
        sum += particles[row].count;
    }
    sums[lane] = sum;
    barrier();
    uint at = 0u;
    for (uint i = 0u; i < lane; ++i) {
        at += sums[i];
    }
    for (uint row = first; row < last; ++row) {
        uint count = particles[row].count;
        for (uint k = 0u; k < count; ++k) {
            sprite_list[at++] = uvec2(row, k);
        }
    }
    if (lane == gl_WorkGroupSize.x - 1u) {
        control.sprite_draw = uvec4(QUAD_VERTICES, at, 0u, 0u);
    }
}
