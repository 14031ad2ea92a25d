// Rounds of a single workgroup: all samples that have as many neighbours with a colour as any has get theirs at once.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "samples.glsl"
layout(local_size_x = 256) in;
#include "inward.glsl"
#include "sides.glsl"
#include "hsv.glsl"

layout(constant_id = 1) const uint MOST_ITERATIONS = 1u;   // of the loops of all rounds
const uint ROUND_ITERATIONS = 5u;      // of a round, and of what a lane does in it with one sample
const uint SAMPLE_ITERATIONS = 11u;

shared uvec3 current;  // list, its first and its last sample

// What a frame shows of a sample.
vec4 side_of(uint index, uint side) {
    uvec4 words = sample_sides[index];
    return unpacked(side == 0u ? words.xy : words.zw);
}

vec4 mean_of(uint index, uint state) {
    vec4 sum = vec4(0.0);
    float count = 0.0;
    uint side = (state & MASK) == SHOWN_NEXT ? 1u : 0u;
    for (uint direction = 0u; direction < 4u; ++direction) {
        uint other = neighbour(index, direction);
        if (other == NONE) {
            continue;
        }
        uint there = sample_states[other];
        if (is_kin(state, there) && has_colour(there)) {
            vec4 colour = sample_colours[other];
            sum += GRADIENT == 1u ? change(colour, side_of(other, side)) : colour;
            count += 1.0;
        }
    }
    vec4 mean = sum / count;
    float brightest = max(uintBitsToFloat(completing[LARGEST_VALUE]), 1.0);
    return GRADIENT == 1u ? changed(side_of(index, side), mean, brightest) : mean;
}

// The samples around one that has got its colour have one more.
void tell(uint index, uint state) {
    for (uint direction = 0u; direction < 4u; ++direction) {
        uint other = neighbour(index, direction);
        if (other == NONE) {
            continue;
        }
        uint there = sample_states[other];
        if (is_wanted(there) && (there & MADE) == 0u && is_kin(there, state)) {
            uint before = atomicAdd(sample_states[other], 1u << COUNT_SHIFT);
            list(other, (before >> COUNT_SHIFT) + 1u);
        }
    }
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint iterations = 0u;
    for (uint round = 0u; round < MOST_ITERATIONS / ROUND_ITERATIONS; ++round) {
        if (lane == 0u) {
            current = uvec3(NONE, 0u, 0u);
            uint first = 8u * GRADIENT;
            for (uint i = 0u; i < 4u && completing[OVERFLOWS + GRADIENT] == 0u; ++i) {
                uint begin = completing[HEADS + first + i];
                uint end = completing[TAILS + first + i];
                current = end > begin ? uvec3(i, begin, end) : current;
            }
        }
        barrier();
        uvec3 now = current;
        iterations += ROUND_ITERATIONS + SAMPLE_ITERATIONS * ((now.z - now.y + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x);
        if (now.x == NONE || iterations > MOST_ITERATIONS) {
            break;
        }
        uint list_at = now.x * params.list_room;
        for (uint i = now.y + lane; i < now.z; i += gl_WorkGroupSize.x) {
            uint index = lists[list_at + i];
            uint state = sample_states[index];
            // What has got more neighbours since stands in another list.
            if (is_wanted(state) && state >> COUNT_SHIFT == now.x + 1u) {
                sample_colours[index] = mean_of(index, state);
                atomicOr(sample_states[index], MADE);
            }
        }
        memoryBarrierBuffer();
        barrier();
        for (uint i = now.y + lane; i < now.z; i += gl_WorkGroupSize.x) {
            uint index = lists[list_at + i];
            uint state = sample_states[index];
            if ((state & (MADE | PENDING)) == (MADE | PENDING)) {
                tell(index, state);
            }
        }
        memoryBarrierBuffer();
        barrier();
        for (uint i = now.y + lane; i < now.z; i += gl_WorkGroupSize.x) {
            uint index = lists[list_at + i];
            uint state = sample_states[index];
            if ((state & (MADE | PENDING)) == (MADE | PENDING)) {
                sample_states[index] = (state & ~(MADE | PENDING)) | KNOWN;
            }
        }
        if (lane == 0u) {
            completing[HEADS + 8u * GRADIENT + now.x] = now.z;
        }
        memoryBarrierBuffer();
        barrier();
    }
}
