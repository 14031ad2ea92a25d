// Floats and their bits.
bool is_finite(float v) {
    return (floatBitsToUint(v) & 0x7f800000u) != 0x7f800000u;
}

// A number whose unsigned order is the order of the floats.
uint ordered(float v) {
    uint bits = floatBitsToUint(v);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float from_ordered(uint v) {
    return uintBitsToFloat((v & 0x80000000u) != 0u ? v ^ 0x80000000u : ~v);
}
