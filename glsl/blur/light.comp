// A round of the search for the light's directions in both frames: a workgroup a candidate. The first round has half of all
// directions, as the other half is the same with tones the other way round; each later one what lies around the best.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "samples.glsl"
#include "tones.glsl"
layout(local_size_x = 64) in;  // few: there are many groups, which often wait for their lanes
#include "solve.glsl"
layout(push_constant) uniform LightConstants {
    uint round;
} constants;

const float TURN = 2.399963229728653;  // golden angle

shared uint unexplained;

// The `index`-th of `count` directions spread evenly over half of the sphere.
vec3 spread(uint index, uint count) {
    float z = 1.0 - (float(index) + 0.5) / float(count);
    float angle = TURN * float(index);
    return vec3(sqrt(1.0 - z * z) * vec2(cos(angle), sin(angle)), z);
}

// A direction, or one of `count` around it.
vec3 beside(vec3 light, uint index, uint count, float distance) {
    if (index == 0u) {
        return light;
    }
    vec3 size = abs(light);
    vec3 axis = size.x <= size.y && size.x <= size.z ? vec3(1.0, 0.0, 0.0) : size.y <= size.z ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    vec3 across = normalize(cross(light, axis));
    float angle = 6.283185307179586 * float(index - 1u) / float(count);
    return normalize(light + distance * (cos(angle) * across + sin(angle) * cross(light, across)));
}

void main() {
    begin_solving();
    uint index = gl_WorkGroupID.x;
    uint round = constants.round;
    vec3 earlier;
    vec3 later;
    if (round == 0u) {
        bool is_still = index < STILL_STARTS;
        uint turned = index - STILL_STARTS;
        earlier = is_still ? spread(index, STILL_STARTS) : spread(turned / TURNED_STARTS, (STARTS - STILL_STARTS) / TURNED_STARTS);
        later = is_still ? earlier : beside(earlier, 1u + turned % TURNED_STARTS, TURNED_STARTS, AROUND);
    } else {
        uint best = candidate_at(round - 1u, best_of(round - 1u));
        float distance = REACH / float(1u << round);
        earlier = beside(lights[best].xyz, index / BESIDE, BESIDE - 1u, distance);
        later = beside(lights[best + 1u].xyz, index % BESIDE, BESIDE - 1u, distance);
    }
    uint steps = round == 0u ? FIRST_STEPS : SEARCH_STEPS;
    uvec2 range = places(round);
    if (gl_LocalInvocationIndex == 0u) {
        unexplained = 0u;
    }
    barrier();
    // Without a place every light explains all there is: nothing.
    if (range.y > 0u) {
        gather(range, earlier, later, steps, 0u, ALL);
        solve(steps);
        gather(range, earlier, later, steps, CLEAR, ALL);
        solve(steps);
    }
    uint sum = 0u;
    for (uint i = gl_LocalInvocationIndex; i < range.y; i += gl_WorkGroupSize.x) {
        Site site = sites[range.x + i];
        sum += uint(site.change.w) * badness(residual_of(site, steps_at(site, earlier, later, steps)));
    }
    atomicAdd(unexplained, sum);
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        // A light that turns must explain clearly more than one that stays.
        uint worse = round == 0u && index >= STILL_STARTS ? unexplained / 8u : 0u;
        uint at = candidate_at(round, index);
        lights[at] = vec4(earlier, uintBitsToFloat(unexplained + worse));
        lights[at + 1u] = vec4(later, 0.0);
    }
}
