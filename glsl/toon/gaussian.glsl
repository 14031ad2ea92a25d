// A Gaussian along an axis. A thread makes TAPS neighbouring results from registers. Blocks of as many taps are added from
// the window's ends inwards, small weights first, which keeps single precision within 2e-6 of the exact sum. The including
// kernel says TAPS and binds `weights`: by distance, 0 beyond the window.

// Weights of taps at TAPS * block + 0, 1, ... for results at 0, 1, ...: tap t weighs [t - o + TAPS - 1] for result o.
float[2 * TAPS - 1] tap_weights(int block) {
    float w[2 * TAPS - 1];
    for (int i = 0; i < 2 * TAPS - 1; ++i) {
        w[i] = weights[abs(TAPS * block + i - (TAPS - 1))];
    }
    return w;
}

// Those of the taps as many blocks to the other side, where `side` is -1.
float[2 * TAPS - 1] on_side(float w[2 * TAPS - 1], int side) {
    float own[2 * TAPS - 1];
    for (int i = 0; i < 2 * TAPS - 1; ++i) {
        own[i] = side < 0 ? w[2 * TAPS - 2 - i] : w[i];
    }
    return own;
}

void add_values(inout float sums[TAPS], float w[2 * TAPS - 1], float values[TAPS]) {
    for (int o = 0; o < TAPS; ++o) {
        float sum = 0.0;
        for (int t = 0; t < TAPS; ++t) {
            sum += w[t - o + (TAPS - 1)] * values[t];
        }
        sums[o] += sum;
    }
}
