// How many render particles the particles of each block have in a repetition.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) writeonly buffer SpriteSums { uint block_sums[]; };
#define SCAN_TYPE uint
#include "common/scan.glsl"

void main() {
    uint row = gl_GlobalInvocationID.x;
    uint all = scan_workgroup(row < params.particle_count ? particles[row].count : 0u).all;
    if (gl_LocalInvocationID.x == 0u) {
        block_sums[gl_WorkGroupID.x] = all;
    }
}
