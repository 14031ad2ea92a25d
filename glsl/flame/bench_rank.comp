// Each particle's place in the order of the depths of their centres, nearest first; the same depths by row.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) writeonly buffer Ranks { uint ranks[]; };
layout(std430, binding = 3) writeonly buffer Order { uint order[]; };

shared float depths[gl_WorkGroupSize.x];

void main() {
    uint row = gl_GlobalInvocationID.x;
    uint lane = gl_LocalInvocationID.x;
    uint count = params.particle_count;
    float own = row < count ? particles[row].depth : 0.0;
    uint rank = 0u;
    for (uint base = 0u; base < count; base += gl_WorkGroupSize.x) {
        uint other = base + lane;
        depths[lane] = other < count ? particles[other].depth : uintBitsToFloat(INFINITY_BITS);
        barrier();
        for (uint i = 0u; i < gl_WorkGroupSize.x; ++i) {
            float z = depths[i];
            rank += z < own || (z == own && base + i < row) ? 1u : 0u;
        }
        barrier();
    }
    if (row < count) {
        ranks[row] = rank;
        order[rank] = row;
    }
}
