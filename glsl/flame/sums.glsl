const float WORD = 4294967296.0;  // 2^32

// A pixel's sums over repetitions. Integers: no order changes them; colours and their squares take two words.
struct Sum {
    uvec3 low;          // of colours, in LIGHT_STEPS of the brightest
    uvec3 high;
    uvec3 square_low;   // of their squares
    uvec3 square_high;
    uint hits;
    float depth;        // of what was nearest, in the order of the repetitions
};

Sum no_sum() {
    return Sum(uvec3(0u), uvec3(0u), uvec3(0u), uvec3(0u), 0u, 0.0);
}

Sum load_sum(uint pixel) {
    uvec4 a = sums[SUM_VECTORS * pixel];
    uvec4 b = sums[SUM_VECTORS * pixel + 1u];
    uvec4 c = sums[SUM_VECTORS * pixel + 2u];
    uvec4 d = sums[SUM_VECTORS * pixel + 3u];
    return Sum(a.xyz, b.xyz, c.xyz, d.xyz, a.w, uintBitsToFloat(b.w));
}
