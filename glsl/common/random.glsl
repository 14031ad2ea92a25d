// Counter-based randomness: a pure function of its keys (PCG, O'Neill 2014), no state.
uint pcg(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

uint hash(uint seed, uint slot, uint generation, uint dimension) {
    return pcg(dimension + pcg(generation + pcg(slot + pcg(seed))));
}

// In (0, 1), exact in single precision.
float unit(uint h) {
    return (float(h >> 9) + 0.5) * 1.1920928955078125e-7;
}

// floor(n * h / 2^32): uniform in 0 .. n - 1.
uint below(uint h, uint n) {
    uint high, low;
    umulExtended(h, n, high, low);
    return high;
}
