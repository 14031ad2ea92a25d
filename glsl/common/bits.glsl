// Floats and their bits.
#ifndef BITS
#define BITS

const uint INFINITY_BITS = 0x7f800000u;
const uint SIGN_BIT = 0x80000000u;
#define INFINITY uintBitsToFloat(INFINITY_BITS)

// Neither infinite nor NaN.
bool is_finite(float v) {
    return (floatBitsToUint(v) & INFINITY_BITS) != INFINITY_BITS;
}

// A number whose unsigned order is the order of the floats.
uint ordered(float v) {
    uint bits = floatBitsToUint(v);
    return (bits & SIGN_BIT) != 0u ? ~bits : bits | SIGN_BIT;
}

float from_ordered(uint v) {
    return uintBitsToFloat((v & SIGN_BIT) != 0u ? v ^ SIGN_BIT : ~v);
}

#endif
