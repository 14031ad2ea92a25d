// Each particle's class of the kernel table: the one of the nearest threshold, weighed by how much more or less of the mask passes the
// particle's own.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) buffer Particles { Particle particles[]; };
layout(std430, binding = 3) buffer ControlBuffer { Control control; };
layout(binding = 2, r32f) uniform readonly image2D levels;
#include "kernel.glsl"
#include "pass_count.glsl"

float passing(float threshold) {
    uint count = 0u;
    for (uint variant = 0u; variant < params.variants; ++variant) {
        count += pass_count(MASK_LEVELS - 1u, uvec2(0u), variant, threshold);
    }
    return float(count);
}

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= params.particle_count || particles[row].count == 0u) {
        return;
    }
    float alpha = particles[row].colour.a;
    // Without alpha all of the mask passes, or nothing.
    float threshold = alpha > 0.0 ? params.threshold / alpha : params.threshold > 0.0 ? 2.0 : 0.0;
    uint class_index = uint(class_place(threshold) + 0.5);
    float weight = float(particles[row].count) * passing(threshold) / max(passing(class_threshold(class_index)), 1.0);
    float pixel = params.pixel_slope * (particles[row].depth + uintBitsToFloat(control.base));
    // What is narrower than a pixel needs no table: how often one of its sprites, which fills a part of its pixel, passes there.
    float all = float(params.variants * MASK_SIDE * MASK_SIDE);
    float side = min(params.sprite_size / max(pixel, 1e-30), 1.0);
    bool narrow = is_narrow(pixel);
    if (!narrow) {
        atomicOr(control.classes, 1u << class_index);
    }
    particles[row].class_index = class_index;
    particles[row].weight = narrow ? float(particles[row].count) : weight;
    particles[row].chance = side * side * passing(threshold) / all;
}
