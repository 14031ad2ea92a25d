// Means of what has been learnt at each normal, and bins that are empty by push and pull: a workgroup a table. Where a frame
// shows nothing at a normal, what the other one does is better than what it shows at others: light stays.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "bins.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Sums { uint sums[]; };
layout(std430, binding = 2) writeonly buffer Tables { uvec4 tables[]; };  // NONE: no colour

const uint LEVELS = 6u;                      // of 32, 16, 8, 4, 2 and 1 bins a side, one after another
const uint ENTRIES = (4u * BINS - 1u) / 3u;  // of all levels
const uint WORDS = (ENTRIES + 31u) / 32u;

shared uvec2 colours[ENTRIES];  // two channels a word
shared uint full[WORDS];

uint first_of(uint level) {
    return (4u * BINS - (4u * BINS >> 2u * level)) / 3u;
}

bool is_full(uint at) {
    return (full[at / 32u] >> at % 32u & 1u) != 0u;
}

void keep(uint at, uvec4 units) {
    colours[at] = uvec2(units.x | units.y << 16, units.z | units.w << 16);
    atomicOr(full[at / 32u], 1u << at % 32u);
}

uvec4 colour_of(uint at) {
    uvec2 words = colours[at];
    return uvec4(words.x & 0xffffu, words.x >> 16, words.y & 0xffffu, words.y >> 16);
}

// A sum of 64 bits by a number, halves rounded up: the largest whole number that is not too large. It has 16 bits.
uint mean_of(uint low, uint high, uint count) {
    uint sum_low = low + count / 2u;
    uint sum_high = high + (sum_low < low ? 1u : 0u);
    uint mean = 0u;
    for (uint bit = 32768u; bit > 0u; bit >>= 1) {
        uint product_high;
        uint product_low;
        umulExtended(mean | bit, count, product_high, product_low);
        if (product_high < sum_high || (product_high == sum_high && product_low <= sum_low)) {
            mean |= bit;
        }
    }
    return mean;
}

// A bin of a level with `side` bins a side. Over a border lies the same border, the other way round.
uvec4 bin_at(uint level, ivec2 at) {
    int side = int(SIDE >> level);
    if (at.x < 0 || at.x >= side) {
        at = ivec2(clamp(at.x, 0, side - 1), side - 1 - at.y);
    }
    if (at.y < 0 || at.y >= side) {
        at = ivec2(side - 1 - at.x, clamp(at.y, 0, side - 1));
    }
    return colour_of(first_of(level) + uint(at.y * side + at.x));
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint table = gl_WorkGroupID.x * BINS;
    if (lane < WORDS) {
        full[lane] = 0u;
    }
    barrier();
    // What this frame shows, and the other.
    uint other = (gl_WorkGroupID.x ^ 1u) * BINS;
    for (uint bin = lane; bin < BINS; bin += gl_WorkGroupSize.x) {
        uint own = table * BIN_FIELDS + bin;
        uint at = sums[own] > 0u ? own : other * BIN_FIELDS + bin;
        uint count = sums[at];
        if (count > 0u) {
            uvec4 units;
            for (uint i = 0u; i < 4u; ++i) {
                units[i] = mean_of(sums[at + (1u + i) * BINS], sums[at + (5u + i) * BINS], count);
            }
            keep(bin, units);
        }
    }
    barrier();
    for (uint level = 1u; level < LEVELS; ++level) {
        uint side = SIDE >> level;
        if (lane < side * side) {
            uint child = first_of(level - 1u) + 2u * (lane / side) * 2u * side + 2u * (lane % side);
            uvec4 sum = uvec4(0u);
            uint count = 0u;
            for (uint i = 0u; i < 4u; ++i) {
                uint at = child + (i & 1u) + (i >> 1) * 2u * side;
                if (is_full(at)) {
                    sum += colour_of(at);
                    count += 1u;
                }
            }
            if (count > 0u) {
                keep(first_of(level) + lane, (sum + count / 2u) / count);
            }
        }
        barrier();
    }
    bool is_empty = !is_full(first_of(LEVELS - 1u));
    for (int level = int(LEVELS) - 2; level >= 0 && !is_empty; --level) {
        uint side = SIDE >> uint(level);
        for (uint bin = lane; bin < side * side; bin += gl_WorkGroupSize.x) {
            uint at = first_of(uint(level)) + bin;
            if (!is_full(at)) {
                ivec2 place = ivec2(bin % side, bin / side);
                ivec2 own = place / 2;
                ivec2 beside = own + 2 * (place % 2) - 1;
                uint above = uint(level) + 1u;
                keep(at, (9u * bin_at(above, own) + 3u * bin_at(above, ivec2(beside.x, own.y))
                    + 3u * bin_at(above, ivec2(own.x, beside.y)) + bin_at(above, beside) + 8u) / 16u);
            }
        }
        barrier();
    }
    for (uint bin = lane; bin < BINS; bin += gl_WorkGroupSize.x) {
        tables[table + bin] = is_empty ? uvec4(NONE) : colour_of(bin);
    }
}
