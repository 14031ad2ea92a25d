// Colours that are made from those of neighbours, from the samples with most of these inward.
#include "picture.glsl"

coherent layout(std430, binding = 1) buffer SampleColours { vec4 sample_colours[]; };
coherent layout(std430, binding = 2) buffer SampleStates { uint sample_states[]; };
layout(std430, binding = 3) readonly buffer SampleSides { uvec4 sample_sides[]; };
coherent layout(std430, binding = 4) buffer Lists { uint lists[]; };
coherent layout(std430, binding = 5) buffer Completing { uint completing[]; };
layout(constant_id = 0) const uint GRADIENT = 0;  // 1: of samples that one frame shows; 0: of those that neither does

// The neighbour of a sample to the left, to the right, above or below.
uint neighbour(uint index, uint direction) {
    ivec2 size = ivec2(2u * params.size);
    ivec2 at = ivec2(index % uint(size.x), index / uint(size.x));
    at += direction < 2u ? ivec2(2 * int(direction) - 1, 0) : ivec2(0, 2 * int(direction) - 5);
    bool is_inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
    return is_inside ? index_of_sample(at) : NONE;
}

// Whether a sample is one that this fills.
bool is_wanted(uint state) {
    return (state & PENDING) != 0u && (GRADIENT == 1u ? (state & MASK) != 0u : (state & MASK) == 0u);
}

// Whether a sample can give a wanted one a colour, as soon as it has its own.
bool is_kin(uint own, uint other) {
    uint mask = other & MASK;
    return GRADIENT == 1u ? mask != NOTHING_SEEN && (mask & own & MASK) != 0u : mask != NOTHING_SEEN;
}

bool has_colour(uint state) {
    return (state & KNOWN) != 0u || (GRADIENT == 0u && (state & MASK) != 0u);
}

// Puts a sample into the list of those with so many neighbours, 1 to 4.
void list(uint index, uint count) {
    uint at = atomicAdd(completing[TAILS + 8u * GRADIENT + count - 1u], 1u);
    if (at < params.list_room) {
        lists[(count - 1u) * params.list_room + at] = index;
    } else {
        atomicOr(completing[OVERFLOWS + GRADIENT], 1u);
    }
}
