// Morton codes of two and three numbers.

uint even_bits(uint v) {
    v &= 0x55555555u;
    v = (v | v >> 1) & 0x33333333u;
    v = (v | v >> 2) & 0x0f0f0f0fu;
    v = (v | v >> 4) & 0x00ff00ffu;
    return (v | v >> 8) & 0x0000ffffu;
}

// Of 16 bits, to every second one.
uint to_even_bits(uint v) {
    v = (v | v << 8) & 0x00ff00ffu;
    v = (v | v << 4) & 0x0f0f0f0fu;
    v = (v | v << 2) & 0x33333333u;
    return (v | v << 1) & 0x55555555u;
}

// Every third of 24 bits.
uint third_bits(uint v) {
    v &= 0x00249249u;
    v = (v | v >> 2) & 0x000c30c3u;
    v = (v | v >> 4) & 0x0000f00fu;
    return (v | v >> 8) & 0x000000ffu;
}

// Of 8 bits, to every third one.
uint to_third_bits(uint v) {
    v = (v | v << 8) & 0x0000f00fu;
    v = (v | v << 4) & 0x000c30c3u;
    return (v | v << 2) & 0x00249249u;
}
