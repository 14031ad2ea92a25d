// The plain separable Gaussian, as well tuned as the masked one: eight results a thread from registers, the same
// weights. The image goes on beyond its border with the border's pixels, so the weights' sum is the same everywhere.
#include "params.glsl"
#include "pixel.glsl"
#include "gaussian.glsl"
layout(constant_id = 0) const float SCALE = 1.0;  // 1 / sum of the weights

float sums[8];

void add_plain_taps(int block, float values[8]) {
    float w[15];
    for (int i = 0; i < 15; ++i) {
        w[i] = weights[abs(8 * block + i - 7)];
    }
    for (int o = 0; o < 8; ++o) {
        float n = 0.0;
        for (int t = 0; t < 8; ++t) {
            n += w[t - o + 7] * values[t];
        }
        sums[o] += n;
    }
}
