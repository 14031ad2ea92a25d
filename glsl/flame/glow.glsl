// A wide Gaussian of what is brighter than 1, along an axis, for TAPS neighbouring results.
#define TAPS 4
#include "toon/gaussian.glsl"

vec3 glow[TAPS];

void clear_glow() {
    for (int o = 0; o < TAPS; ++o) {
        glow[o] = vec3(0.0);
    }
}

void add_light(float w[2 * TAPS - 1], vec3 light[TAPS]) {
    for (int o = 0; o < TAPS; ++o) {
        vec3 sum = vec3(0.0);
        for (int t = 0; t < TAPS; ++t) {
            sum += w[t - o + (TAPS - 1)] * light[t];
        }
        glow[o] += sum;
    }
}

// Blocks of taps that reach over the window.
int glow_blocks() {
    return (params.glow_window + TAPS - 1 + TAPS - 1) / TAPS;
}
