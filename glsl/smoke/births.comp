// Exclusive prefix sum of the birth counts, in one workgroup.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "lanes.glsl"
layout(std430, binding = 1) buffer BirthCounts { uint birth_counts[]; };
layout(std430, binding = 2) buffer HistoryBuffer { History history; };
layout(push_constant) uniform BirthsConstants { uint blocks; } constants;

shared uint sums[gl_WorkGroupSize.x];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uvec2 run = own_run(constants.blocks);
    uint sum = 0u;
    for (uint i = run.x; i < run.y; ++i) {
        uint count = birth_counts[i];
        birth_counts[i] = sum;
        sum += count;
    }
    sums[lane] = sum;
    barrier();
    uint before = 0u;
    for (uint i = 0u; i < lane; ++i) {
        before += sums[i];
    }
    for (uint i = run.x; i < run.y; ++i) {
        birth_counts[i] += before;
    }
    if (lane == gl_WorkGroupSize.x - 1u) {
        history.births = before + sum;
        // One more entry: the total.
        birth_counts[constants.blocks] = before + sum;
    }
}
