// Where each workgroup's triangles go, in one workgroup; and what the next round is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) buffer Rounds { Round rounds[]; };
layout(std430, binding = 2) buffer Blocks { uvec2 blocks[]; };
layout(std430, binding = 3) buffer ControlBuffer { Control control; };
#include "round.glsl"

shared uvec2 sums[gl_WorkGroupSize.x];

void main() {
    uint lane = gl_LocalInvocationID.x;
    Round current = rounds[constants.round];
    uint count = current.groups.x;
    uint share = (count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint first = min(lane * share, count);
    uint last = min(first + share, count);
    uvec2 sum = uvec2(0u);
    for (uint i = first; i < last; ++i) {
        uvec2 own = blocks[i];
        blocks[i] = sum;
        sum += own;
    }
    sums[lane] = sum;
    barrier();
    uvec2 before = uvec2(0u);
    uvec2 all = uvec2(0u);
    for (uint i = 0u; i < gl_WorkGroupSize.x; ++i) {
        before += i < lane ? sums[i] : uvec2(0u);
        all += sums[i];
    }
    for (uint i = first; i < last; ++i) {
        blocks[i] += before;
    }
    if (lane == 0u) {
        uint triangles = current.triangles;
        bool over = current.finished_before + triangles - all.y + all.x > params.triangle_budget;
        bool ends = over || constants.round == ROUNDS;
        if (all.x > 0u && ends) {
            rounds[constants.round].is_last = 1u;
            control.ended_by = over ? ENDED_BY_BUDGET : ENDED_BY_ROUNDS;
            control.undivided = all.y;
            all = uvec2(0u);
        }
        uint finished = current.finished_before + triangles - all.y;
        uint made = current.vertices_before + all.x - all.y;
        uint groups = (all.x + BLOCK - 1u) / BLOCK;
        if (constants.round < ROUNDS) {
            rounds[constants.round + 1u] = Round(uvec4(groups, 1u, 1u, 0u), uvec4(groups > 0u ? 1u : 0u, 1u, 1u, 0u),
                                                 all.x, 0u, finished, made);
        }
        control.triangles = finished;
        control.vertices = made;
        control.draw = uvec4(3u * finished, 1u, 0u, 0u);
    }
}
