// What the two passes of the masked Gaussian share (paper, section 3.3, as a normalised convolution per group: exact).
// A thread makes eight neighbouring results from registers. Blocks of eight taps are added from the window's ends
// inwards, small weights first, which keeps single precision within 2e-6 of the exact sum.
#include "reach.glsl"
layout(local_size_x = 8, local_size_y = 16) in;
layout(std430, binding = 1) readonly buffer Weights { float weights[]; };  // by distance, 0 beyond the window
layout(std430, binding = 2) readonly buffer Reached { Reach reached[]; };
layout(push_constant) uniform GaussianConstants {
    uint base;         // first entry of the batch
    uint first_group;
} constants;

float numerator[8];
float denominator[8];

// Adds taps at 8 * block + 0 .. 7 to the results at 0 .. 7.
void add_taps(int block, float values[8], float masks[8]) {
    float w[15];
    for (int i = 0; i < 15; ++i) {
        w[i] = weights[abs(8 * block + i - 7)];
    }
    for (int o = 0; o < 8; ++o) {
        float n = 0.0;
        float d = 0.0;
        for (int t = 0; t < 8; ++t) {
            n += w[t - o + 7] * values[t];
            d += w[t - o + 7] * masks[t];
        }
        numerator[o] += n;
        denominator[o] += d;
    }
}
