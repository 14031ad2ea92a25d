// What a render particle draws: a pure function of seed, particle, sample and repetition, with + - * / and square roots
// only, whose results differ between devices by roundings at most.
#include "../common/random.glsl"

layout(constant_id = 1) const uint CUBE = 0;     // 1: offsets fill a cube, not a ball
layout(constant_id = 2) const uint SOBOL = 0;    // 1: offsets are stratified over the repetitions
layout(constant_id = 3) const uint FLICKER = 0;  // 1: some draws change from frame to frame

// How often a render particle has been drawn anew up to this frame, times an odd number that is added to its words.
uint flickered(uint particle_word) {
    uint phase = pcg(PHASE_KEY + particle_word) >> 16u;
    return FLICKER == 1u ? (params.flicker_whole + ((params.flicker_fraction + phase) >> 16u)) * RENEWAL : 0u;
}

// The word that all draws of a render particle come from. `particle_word`: hash of its particle's id and its sample.
uint draw_word(uint particle_word, uint repetition) {
    return pcg(repetition + particle_word) + flickered(particle_word);
}

// Owen scrambling of a word whose bits are reversed (Laine and Karras 2011, with a better hash).
uint scrambled_reversed(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

uint scrambled(uint x, uint seed) {
    return bitfieldReverse(scrambled_reversed(bitfieldReverse(x), seed));
}

// Point `repetition` of a Sobol sequence of the render particle's own: its order shuffled, its coordinates scrambled.
vec3 sobol_point(uint particle_word, uint repetition) {
    uint seed = pcg(SOBOL_KEY + particle_word) + flickered(particle_word);
    uint bits = params.sobol_bits;
    uint index = scrambled(repetition, pcg(seed)) & ((1u << bits) - 1u);
    uvec3 direction = uvec3(0x80000000u);
    uint before = 0u;
    uvec3 point = uvec3(0u);
    for (uint bit = 0u; bit < bits; ++bit) {
        point ^= (index >> bit & 1u) == 1u ? direction : uvec3(0u);
        // The next direction numbers: van der Corput; x + 1; x^2 + x + 1 (m = 1, 3).
        uint third = bit == 0u ? 0xc0000000u : direction.z ^ before ^ before >> 2u;
        before = direction.z;
        direction = uvec3(direction.x >> 1u, direction.y ^ direction.y >> 1u, third);
    }
    return vec3(unit(scrambled(point.x, pcg(seed + 1u))), unit(scrambled(point.y, pcg(seed + 2u))),
                unit(scrambled(point.z, pcg(seed + 3u))));
}

// Cosine and sine of u turns, 0 <= u < 1, to 2e-7: by quarter turns and a polynomial, not by the device's functions.
vec2 circle(float u) {
    float quarter = floor(4.0 * u + 0.5);
    precise float a = (4.0 * u - quarter) * 1.5707963267948966;
    precise float b = a * a;
    precise float s = a * (1.0 + b * (-0.16666667 + b * (0.0083333310 + b * -0.00019840874)));
    precise float c = 1.0 + b * (-0.5 + b * (0.041666638 + b * (-0.0013888378 + b * 0.000024433157)));
    uint turn = uint(quarter) & 3u;
    vec2 turned = (turn & 1u) == 0u ? vec2(c, s) : vec2(-s, c);
    return (turn & 2u) == 0u ? turned : -turned;
}

// The cube root of u, 0 < u < 1, to 2e-7: a guess from the exponent, improved twice (Halley).
float cube_root(float u) {
    float y = uintBitsToFloat(floatBitsToUint(u) / 3u + 709921077u);
    for (uint i = 0u; i < 2u; ++i) {
        float cube = y * y * y;
        y = y * (cube + 2.0 * u) / (2.0 * cube + u);
    }
    return y;
}

// Offset from the particle's centre along the world's axes, in spreads.
vec3 draw_offset(uint word, uint particle_word, uint repetition) {
    vec3 u = SOBOL == 1u ? sobol_point(particle_word, repetition) : vec3(unit(pcg(word)), unit(pcg(word + 1u)), unit(pcg(word + 2u)));
    if (CUBE == 1u) {
        return 2.0 * u - 1.0;
    }
    float z = 1.0 - 2.0 * u.x;
    float across = 2.0 * sqrt(u.x * (1.0 - u.x));
    return cube_root(u.z) * vec3(across * circle(u.y), z);
}
