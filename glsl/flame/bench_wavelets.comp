// Wavelet transparency (Aizenshtein, Smal and McGuire 2022): the absorbance before a depth, a sum of steps, in Haar wavelets of rank 3, in single
// precision. They hold its mean in each of 16 bins. As in the implementation by Osorio (2024, osor.io/OIT) means are interpolated, no particle is in
// the last bin, so that the total is exact, and a particle does not see itself.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "bench_blend.glsl"
#include "bench_transmittance.glsl"

#include "bench_wavelets.glsl"

// Of the constant, then of wavelet k of level j at 2^j + k.
float coefficients[WAVELET_BINS];

// Where a depth lies, in bins.
float bin_place(float depth) {
    return depth * float(WAVELET_BINS - 1u);
}

void clear_function() {
    [[unroll]] for (uint k = 0u; k < WAVELET_BINS; ++k) {
        coefficients[k] = 0.0;
    }
}

void record(float depth, float amount) {
    float x = bin_place(depth) / float(WAVELET_BINS);
    coefficients[0] += amount * (1.0 - x);
    [[unroll]] for (uint level = 0u; level <= WAVELET_RANK; ++level) {
        float scale = float(1u << level);
        float place = x * scale;
        float along = fract(place);
        // The integral from x on of a wavelet that is sqrt(scale) and then -sqrt(scale).
        coefficients[(1u << level) + uint(place)] -= amount * min(along, 1.0 - along) * inversesqrt(scale);
    }
}

void conclude(float total) {}

// Mean in a bin.
float bin_mean(uint bin) {
    float mean = coefficients[0];
    [[unroll]] for (uint level = 0u; level <= WAVELET_RANK; ++level) {
        bool is_first = (bin >> (WAVELET_RANK - level) & 1u) == 0u;
        float coefficient = coefficients[(1u << level) + (bin >> (WAVELET_RANK + 1u - level))];
        mean += (is_first ? coefficient : -coefficient) * sqrt(float(1u << level));
    }
    return mean;
}

float absorbance_before(float depth, float own) {
    float place = bin_place(depth);
    uint bin = uint(place);
    float along = place - float(bin);
    float nearer = bin > 0u ? bin_mean(bin - 1u) : 0.0;
    return mix(nearer, bin_mean(bin) - own * (1.0 - along), along);
}
