// Adds a repetition that was drawn to the sums.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) buffer Sums { uvec4 sums[]; };
#extension GL_EXT_samplerless_texture_functions : require
layout(binding = 3) uniform utexture2D drawn;
layout(push_constant) uniform AddConstants { uint is_first; } constants;
#include "winner.glsl"

void main() {
    uint at = gl_GlobalInvocationID.x;
    if (at >= params.size.x * params.size.y) {
        return;
    }
    Sum sum = constants.is_first == 1u ? no_sum() : load_sum(at);
    uvec2 winner = texelFetch(drawn, ivec2(at % params.size.x, at / params.size.x), 0).xy;
    if (winner.x != 0u) {
        add_winner(sum, particles[winner.x - 1u].light, winner.y);
    }
    store_sum(at, sum);
}
