// Counts, of samples that are to get a colour from their neighbours, how many of these have one.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "samples.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
#include "inward.glsl"

void main() {
    uvec2 size = 2u * params.size;
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, size))) {
        return;
    }
    uint index = index_of_sample(ivec2(gl_GlobalInvocationID.xy));
    uint state = sample_states[index];
    if (!is_wanted(state)) {
        return;
    }
    uint count = 0u;
    for (uint direction = 0u; direction < 4u; ++direction) {
        uint other = neighbour(index, direction);
        if (other != NONE) {
            uint there = sample_states[other];
            count += is_kin(state, there) && has_colour(there) ? 1u : 0u;
        }
    }
    if (count > 0u) {
        // Nobody reads others' counts here.
        sample_states[index] = state | count << COUNT_SHIFT;
        list(index, count);
        completing[INWARD_DISPATCHES + 4u * GRADIENT] = 1u;
    }
}
