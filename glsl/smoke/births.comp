// Running sum of the birth counts, in one workgroup.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) buffer BirthCounts { uint birth_counts[]; };
layout(std430, binding = 2) buffer HistoryBuffer { History history; };
layout(push_constant) uniform BirthsConstants { uint blocks; } constants;

shared uint sums[256];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint share = (constants.blocks + 255u) / 256u;
    uint first = min(lane * share, constants.blocks);
    uint last = min(first + share, constants.blocks);
    uint sum = 0u;
    for (uint i = first; i < last; ++i) {
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
    for (uint i = first; i < last; ++i) {
        birth_counts[i] += before;
    }
    if (lane == 255u) {
        history.births = before + sum;
        // One more entry: the total.
        birth_counts[constants.blocks] = before + sum;
    }
}
