// The tones under the light that has been found: of all in a first dispatch, then of each surface, and how well these explain
// what both frames show.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "samples.glsl"
#include "tones.glsl"
layout(local_size_x = 256) in;
#include "solve.glsl"
layout(std430, binding = 4) buffer Tables { uvec4 tables[]; };
layout(push_constant) uniform ToneConstants {
    uint is_own;  // 1: those of surfaces
} constants;

shared uint judged[3];        // what is left unexplained, what there was, places

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint group = gl_WorkGroupID.x;
    uint best = candidate_at(SEARCHES - 1u, best_of(SEARCHES - 1u));
    vec3 earlier = lights[best].xyz;
    vec3 later = lights[best + 1u].xyz;
    uvec2 range = places(SEARCHES);
    begin_solving();
    bool is_own = constants.is_own == 1u;
    uint surface = is_own ? group : ALL;
    uint place = is_own ? group + 1u : 0u;
    // Without a place of its own, a surface has the common tones.
    uint repeats = is_own && completing[SURFACES + 2u * surface] == 0u ? 0u : REPEATS;
    if (lane < 3u * TONE_STEPS) {
        tones[lane] = 0;
    }
    if (lane < 3u) {
        judged[lane] = 0u;
    }
    if (is_own && lane < 3u * TONE_STEPS) {
        common_tones[lane] = int(tables[row_of_tone(0u, lane / 3u)][lane % 3u]);
    }
    barrier();
    for (uint repeat = 0u; repeat < repeats; ++repeat) {
        gather(range, earlier, later, TONE_STEPS, repeat == 0u ? 0u : RESIDUAL, surface);
        solve(TONE_STEPS);
    }
    if (lane < TONE_STEPS) {
        ivec3 whole;
        for (uint i = 0u; i < 3u; ++i) {
            whole[i] = tones[3u * lane + i] + common_tones[3u * lane + i];
        }
        tables[row_of_tone(place, lane)] = uvec4(uvec3(whole), 0u);
    }
    if (lane == 0u) {
        tables[row_of_light(place, 0u)] = uvec4(floatBitsToUint(earlier), 0u);
        tables[row_of_light(place, 1u)] = uvec4(floatBitsToUint(later), 0u);
    }
    if (!is_own || repeats == 0u) {
        return;
    }
    uvec3 all = uvec3(0u);
    for (uint i = lane; i < range.y; i += gl_WorkGroupSize.x) {
        Site site = sites[range.x + i];
        if (uint(site.normals[0].w) == surface) {
            uint left = badness(residual_of(site, steps_at(site, earlier, later, TONE_STEPS)));
            all += uvec3(left, badness(sum_of(site.change.xyz)), 1u);
        }
    }
    for (uint i = 0u; i < 3u; ++i) {
        atomicAdd(judged[i], all[i]);
    }
    barrier();
    if (lane == 0u) {
        atomicAdd(completing[UNEXPLAINED], judged[0]);
        atomicAdd(completing[UNEXPLAINED + 1u], judged[1]);
        completing[SURFACES + 2u * surface] = judged[0];
        completing[SURFACES + 2u * surface + 1u] = 2u * judged[1] + ALLOWED * judged[2];
    }
}
