// The list of all render particles of a repetition, in one workgroup: what the paper's way draws.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 3) writeonly buffer SpriteList { uvec2 sprite_list[]; };
#include "share.glsl"

void main() {
    uvec2 share = share_of_list(params.particle_count);
    uint sum = 0u;
    for (uint row = share.x; row < share.y; ++row) {
        sum += particles[row].count;
    }
    uvec2 sums = prefix_sum(sum);
    uint at = sums.x;
    for (uint row = share.x; row < share.y; ++row) {
        uint count = particles[row].count;
        for (uint k = 0u; k < count; ++k) {
            sprite_list[at++] = uvec2(row, k);
        }
    }
    if (gl_LocalInvocationID.x == 0u) {
        control.sprite_draw = uvec4(QUAD_VERTICES, sums.y, 0u, 0u);
    }
}
