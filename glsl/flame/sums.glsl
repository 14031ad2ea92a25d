// A pixel's sums over repetitions. Integers: no order changes them; colours and their squares take two words.
struct Sum {
    uvec3 low;          // of colours, in 65535ths of the brightest
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
    uvec4 a = sums[4u * pixel];
    uvec4 b = sums[4u * pixel + 1u];
    uvec4 c = sums[4u * pixel + 2u];
    uvec4 d = sums[4u * pixel + 3u];
    return Sum(a.xyz, b.xyz, c.xyz, d.xyz, a.w, uintBitsToFloat(b.w));
}

void store_sum(uint pixel, Sum sum) {
    sums[4u * pixel] = uvec4(sum.low, sum.hits);
    sums[4u * pixel + 1u] = uvec4(sum.high, floatBitsToUint(sum.depth));
    sums[4u * pixel + 2u] = uvec4(sum.square_low, 0u);
    sums[4u * pixel + 3u] = uvec4(sum.square_high, 0u);
}

void add_winner(inout Sum sum, uvec2 light, uint depth) {
    uvec3 colour = uvec3(light.x & 0xffffu, light.x >> 16u, light.y);
    uvec3 square = colour * colour;
    sum.low += colour;
    sum.high += uvec3(lessThan(sum.low, colour));
    sum.square_low += square;
    sum.square_high += uvec3(lessThan(sum.square_low, square));
    sum.hits += 1u;
    sum.depth += uintBitsToFloat(depth);
}
