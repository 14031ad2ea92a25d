// Writes the lists of live and of visible spheres in particle order, and gives each sphere its group: equal ranges of
// centre depth with hysteresis, computed once and kept as an integer (paper, section 3.3). With the mask "soft" groups
// are told without hysteresis, as no picture depends on them; what does are the ranges. The smoothed depth range of the last frame stands in one
// place and this frame's goes to another: all workgroups read the one, and one writes the other.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
#include "view.glsl"
#include "list.glsl"
#include "mask.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 7) readonly buffer ViewSpheres { vec4 view_spheres[]; };
layout(std430, binding = 2) readonly buffer ListSums { uvec2 block_sums[]; };
layout(std430, binding = 3) buffer HistoryBuffer { History history; };
layout(std430, binding = 4) buffer Groups { uint groups[]; };
layout(std430, binding = 5) writeonly buffer Live { uint live_list[]; };
layout(std430, binding = 6) writeonly buffer Visible { uint visible_list[]; };
layout(std430, binding = 8) buffer ControlBuffer { Control control; };
#define SCAN_TYPE uvec2
#define SCAN_BLOCKS
#include "common/scan.glsl"

// The smoothed depth range of live spheres. In a held moment only the camera moves, and the range goes with it.
Range track_range() {
    Range before = history.ranges[params.range_before];
    before.exists = params.frames == 0u ? 0u : before.exists;
    if (control.depth_low > control.depth_high) {
        return before;
    }
    float low = from_ordered(control.depth_low);
    float high = from_ordered(control.depth_high);
    if (before.exists != 0u && params.range_smoothing == HELD_RANGE) {
        return Range(before.low + (low - before.lowest), before.high + (high - before.highest), 1u, low, high);
    }
    bool fresh = before.exists == 0u || high < before.low || low > before.high;
    float kept = fresh ? 0.0 : max(params.range_smoothing, 0.0);
    float smooth_low = kept == 0.0 ? low : kept * before.low + (1.0 - kept) * low;
    float smooth_high = kept == 0.0 ? high : kept * before.high + (1.0 - kept) * high;
    return Range(smooth_low, smooth_high, 1u, low, high);
}

// Where ranges begin, and how wide they are.
vec2 groups_in(Range range) {
    if (params.group_depth > 0.0) {
        return vec2(0.0, params.group_depth);
    }
    return range.exists == 0u ? vec2(0.0) : vec2(range.low, (range.high - range.low) / float(params.group_count));
}

uint group_of(float low, float width, float depth, uint previous) {
    if (width <= 0.0) {
        return 1u;
    }
    float margin = params.hysteresis * width;
    if (previous != 0u) {
        float from = low + float(previous - 1u) * width;
        if (depth >= from - margin && depth <= from + width + margin) {
            return previous;
        }
    }
    return uint(clamp(1.0 + floor((depth - low) / width), 1.0, float(params.group_count)));
}

void main() {
    uint first = gl_GlobalInvocationID.x * LIST_RUN;
    uint end = min(first + LIST_RUN, params.spheres);
    uvec2 count = uvec2(0u);
    for (uint slot = first; slot < end; ++slot) {
        if (is_live(spheres[slot])) {
            count += uvec2(1u, is_visible(view_spheres[slot]) ? 1u : 0u);
        }
    }
    Scan blocks = scan_blocks(gl_WorkGroupID.x, gl_NumWorkGroups.x);
    uvec2 at = blocks.before + scan_workgroup(count).before;
    Range range = track_range();
    vec2 ranges = groups_in(range);
    for (uint slot = first; slot < end; ++slot) {
        uint group = 0u;
        if (is_live(spheres[slot])) {
            vec4 view_sphere = view_spheres[slot];
            group = group_of(ranges.x, ranges.y, view_sphere.z, SOFT || params.frames == 0u ? 0u : groups[slot]);
            live_list[at.x++] = slot;
            if (is_visible(view_sphere)) {
                visible_list[at.y++] = slot;
            }
        }
        groups[slot] = group;
    }
    if (gl_GlobalInvocationID.x == 0u) {
        history.ranges[1u - params.range_before] = range;
        control.group_start = ranges.x;
        control.groups_per_metre = ranges.y > 0.0 ? min(1.0 / ranges.y, 3e38) : 0.0;
        control.live = blocks.all.x;
        control.visible = blocks.all.y;
        control.live_groups = uvec4((blocks.all.x + LIVE_LANES - 1u) / LIVE_LANES, 1u, 1u, 0u);
        control.draw = uvec4(QUAD_VERTICES, blocks.all.y, 0u, 0u);
        control.light_draw = uvec4(QUAD_VERTICES, blocks.all.x, 0u, 0u);
    }
}
