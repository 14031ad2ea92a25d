// What samples of the distorted mesh look like: colours from where its surface is in frames i and i + 1, and what can be
// said of a side that its frame hides. Four samples a pixel.
layout(binding = 18) uniform utexture2D sampled;
layout(std430, binding = 19) readonly buffer CornerGroups { uvec4 corner_groups[]; };
layout(std430, binding = 20) readonly buffer Normals { vec4 normals[]; };
layout(std430, binding = 22) buffer Completing { uint completing[]; };
layout(std430, binding = 23) writeonly buffer SampleColours { vec4 sample_colours[]; };
layout(std430, binding = 24) writeonly buffer SampleStates { uint sample_states[]; };
layout(constant_id = 0) const uint GROUPS = 0;
layout(constant_id = 1) const uint COMPLETION = 0;  // 0: none, or one of these
layout(constant_id = 2) const uint CHOOSES = 0;     // 1: one of two colours, 0: their mixture
const uint FROM_SURFACE = 1u;
const uint FROM_GRADIENT = 2u;
#include "tables.glsl"
#include "mix.glsl"

// Whether a sample of the workgroup is to be made from its neighbours': where neither frame shows it, or one.
shared uint pending[2];

struct Sides {
    vec4 colours[2];  // of frames i and i + 1, or i - 1 and i + 2
    uint known;       // which of them are known: SHOWN_PREVIOUS and SHOWN_NEXT
};

Sides sides_of(Fragment fragment, uvec2 frames, uint wanted) {
    Sides sides = Sides(vec4[2](vec4(0.0), vec4(0.0)), 0u);
    for (uint side = 0u; side < 2u; ++side) {
        if ((wanted >> side & 1u) != 0u) {
            float weight;
            look(frames[side], fragment.base, fragment.barycentrics, sides.colours[side], weight);
            sides.known |= weight > LEAST_WEIGHT ? 1u << side : 0u;
        }
    }
    return sides;
}

// What frames i and i + 1 show.
Sides known_sides(Fragment fragment);

// The colour of a place in a frame, i (0) or i + 1 (1), where neither shows it; w below 0: unknown.
vec4 typical(Fragment fragment, uint frame);

// The same where the other one shows it.
vec4 predicted(Fragment fragment, uint frame, vec4 known);

// Keeps both sides of a sample for its neighbours.
void keep(uint index, Sides sides);

// Both at the time, or what is known of it.
vec4 mixed(Sides sides, float moved) {
    return sides.known == SHOWN_BOTH ? mixture(sides.colours[0], sides.colours[1], moved) : sides.colours[sides.known >> 1];
}

// Colour and state of a sample.
vec4 shade(Fragment fragment, uint index, out uint state) {
    Sides sides = known_sides(fragment);
    uint mask = sides.known;
    keep(index, sides);
    state = mask | KNOWN;
    if (mask == 0u) {
        sides = sides_of(fragment, uvec2(0u, 3u), params.outer_images);
    }
    if (sides.known == 0u && COMPLETION == FROM_SURFACE) {
        for (uint frame = 0u; frame < 2u; ++frame) {
            sides.colours[frame] = typical(fragment, frame);
            sides.known |= sides.colours[frame].w >= 0.0 ? 1u << frame : 0u;
        }
    } else if ((mask == SHOWN_PREVIOUS || mask == SHOWN_NEXT) && COMPLETION != 0u && !is_still(fragment.base)) {
        state = COMPLETION == FROM_GRADIENT ? mask | PENDING : state;
        if (COMPLETION == FROM_SURFACE) {
            vec4 other = predicted(fragment, 2u - mask, sides.colours[mask - 1u]);
            sides.colours[2u - mask] = other;
            sides.known = other.w >= 0.0 ? SHOWN_BOTH : mask;
        }
    }
    state = sides.known == 0u ? PENDING : state;
    return sides.known == 0u ? vec4(0.0) : mixed(sides, fragment.moved);
}

void main() {
    uvec2 part = TILE * uvec2(gl_WorkGroupID.z & 1u, gl_WorkGroupID.z >> 1);
    ivec2 at = ivec2(2u * tile_origin(gl_WorkGroupID) + part + gl_LocalInvocationID.xy);
    uvec2 size = 2u * params.size;
    bool is_inside = all(lessThan(at, ivec2(size)));
    if (gl_LocalInvocationIndex < 2u) {
        pending[gl_LocalInvocationIndex] = 0u;
    }
    barrier();
    uint triangle_id = is_inside ? texelFetch(sampled, at, 0).x : 0u;
    uint state = NOTHING_SEEN;
    vec4 colour = vec4(0.0);
    uint index = index_of_sample(at);
    if (triangle_id > 0u) {
        Fragment fragment = fragment_at(triangle_id, 0.5 * (vec2(at) + 0.5));
        colour = shade(fragment, index, state);
        state |= is_still(fragment.base) ? STILL : 0u;
        if ((state & PENDING) != 0u) {
            atomicOr(pending[(state & MASK) == 0u ? 0 : 1], 1u);
        }
    }
    if (is_inside) {
        sample_colours[index] = colour;
        sample_states[index] = state;
    }
    barrier();
    if (gl_LocalInvocationIndex < 2u && pending[gl_LocalInvocationIndex] > 0u) {
        atomicMax(completing[BORDER_DISPATCHES + 4u * gl_LocalInvocationIndex], (size.x + TILE - 1u) / TILE);
    }
}
