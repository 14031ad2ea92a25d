// The class of a particle in the kernel table: the one of the nearest threshold, weighed by how much more or less of the mask passes the
// particle's own.
#include "kernel.glsl"
#include "pass_count.glsl"

float passing(float threshold) {
    uint count = 0u;
    for (uint variant = 0u; variant < params.variants; ++variant) {
        count += pass_count(MASK_LEVELS - 1u, uvec2(0u), variant, threshold);
    }
    return float(count);
}

void weigh(uint row) {
    float alpha = particles[row].colour.a;
    // Without alpha all of the mask passes, or nothing.
    float threshold = alpha > 0.0 ? params.threshold / alpha : params.threshold > 0.0 ? 2.0 : 0.0;
    uint class_index = uint(class_place(threshold) + 0.5);
    float weight = float(particles[row].count) * passing(threshold) / max(passing(class_threshold(class_index)), 1.0);
    float pixel = params.pixel_footprint * widening(particles[row].depth + uintBitsToFloat(control.base));
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
