// The plain separable Gaussian, as well tuned as the masked one: eight results a thread from registers, the same
// weights. The image goes on beyond its border with the border's pixels, so the weights' sum is the same everywhere.
#include "params.glsl"
#include "gaussian.glsl"
layout(constant_id = 0) const float SCALE = 1.0;  // 1 / sum of the weights

float sums[TAPS];

void add_plain_taps(float w[2 * TAPS - 1], float values[TAPS]) {
    add_values(sums, w, values);
}
