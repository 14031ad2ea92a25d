// What the expected mode's table says where all of a particle's render particles have been met: ln(1 - Q), of its own pass shares and at its
// own classes and places. Balls only.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "kernel.glsl"
layout(local_size_x = KERNEL_LANES) in;
layout(std430, binding = 1) readonly buffer KernelState { KernelTable table; };
layout(std430, binding = 2) readonly buffer Shares { float shares[]; };
layout(std430, binding = 3) writeonly buffer FarTable { float far_table[]; };

void main() {
    uint place = gl_GlobalInvocationID.x % (KERNEL_PLACES * KERNEL_PLACES);
    uint class_index = gl_GlobalInvocationID.x / (KERNEL_PLACES * KERNEL_PLACES);
    if (class_index >= KERNEL_CLASSES) {
        return;
    }
    vec2 m = kernel_reach() * (2.0 * vec2(place % KERNEL_PLACES, place / KERNEL_PLACES) / LAST_PLACE - 1.0);
    uint side = MASK_SIDE >> table.level;
    float texel_side = params.sprite_size / float(side);
    float radius = max(params.spread, 2.0 * texel_side);
    float chords = 0.0;
    for (uint texel = 0u; texel < side * side; ++texel) {
        vec2 u = (vec2(texel % side, texel / side) + 0.5) / float(side) - 0.5;
        vec2 at = m - params.sprite_size * u;
        chords += shares[class_index * side * side + texel] * 2.0 * sqrt(max(radius * radius - dot(at, at), 0.0));
    }
    float p = min(texel_side * texel_side * chords / ball_volume(radius), 1.0);
    far_table[gl_GlobalInvocationID.x] = max(logarithm_of_rest(p), LEAST_LOGARITHM);
}
