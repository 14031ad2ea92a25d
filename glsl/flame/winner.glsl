// Adds to a pixel's sums.
#include "sums.glsl"

void store_sum(uint pixel, Sum sum) {
    sums[SUM_VECTORS * pixel] = uvec4(sum.low, sum.hits);
    sums[SUM_VECTORS * pixel + 1u] = uvec4(sum.high, floatBitsToUint(sum.depth));
    sums[SUM_VECTORS * pixel + 2u] = uvec4(sum.square_low, 0u);
    sums[SUM_VECTORS * pixel + 3u] = uvec4(sum.square_high, 0u);
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
