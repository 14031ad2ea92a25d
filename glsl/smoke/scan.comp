// Exclusive prefix sums of the list counts, in one workgroup; the arguments of what works on the lists; the smoothed depth range.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
#include "lanes.glsl"
layout(std430, binding = 1) buffer ListCounts { uvec2 list_counts[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 3) buffer HistoryBuffer { History history; };

shared uvec2 sums[gl_WorkGroupSize.x];

void track_range() {
    if (params.frames == 0u) {
        history.has_range = 0u;
    }
    float low = from_ordered(control.depth_low);
    float high = from_ordered(control.depth_high);
    if (control.depth_low > control.depth_high) {
        return;
    }
    bool fresh = history.has_range == 0u || high < history.range_low || low > history.range_high;
    float kept = fresh ? 0.0 : params.range_smoothing;
    history.range_low = kept == 0.0 ? low : kept * history.range_low + (1.0 - kept) * low;
    history.range_high = kept == 0.0 ? high : kept * history.range_high + (1.0 - kept) * high;
    history.has_range = 1u;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint blocks = (params.spheres + LIST_RUN - 1u) / LIST_RUN;
    uvec2 run = own_run(blocks);
    uvec2 sum = uvec2(0u);
    for (uint i = run.x; i < run.y; ++i) {
        uvec2 count = list_counts[i];
        list_counts[i] = sum;
        sum += count;
    }
    sums[lane] = sum;
    barrier();
    uvec2 before = uvec2(0u);
    for (uint i = 0u; i < lane; ++i) {
        before += sums[i];
    }
    for (uint i = run.x; i < run.y; ++i) {
        list_counts[i] += before;
    }
    if (lane == gl_WorkGroupSize.x - 1u) {
        uvec2 total = before + sum;
        control.live = total.x;
        control.visible = total.y;
        control.live_groups = uvec4((total.x + LIVE_LANES - 1u) / LIVE_LANES, 1u, 1u, 0u);
        control.draw = uvec4(QUAD_VERTICES, total.y, 0u, 0u);
        control.light_draw = uvec4(QUAD_VERTICES, total.x, 0u, 0u);
        track_range();
    }
}
