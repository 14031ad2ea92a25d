// Writes the lists of live and of visible spheres in particle order, and gives each sphere its group: equal ranges of
// centre depth with hysteresis, computed once and kept as an integer (paper, section 3.3).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "view.glsl"
#include "list.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 7) readonly buffer ViewSpheres { vec4 view_spheres[]; };
layout(std430, binding = 2) readonly buffer ListCounts { uvec2 list_counts[]; };
layout(std430, binding = 3) readonly buffer HistoryBuffer { History history; };
layout(std430, binding = 4) buffer Groups { uint groups[]; };
layout(std430, binding = 5) writeonly buffer Live { uint live_list[]; };
layout(std430, binding = 6) writeonly buffer Visible { uint visible_list[]; };

uint group_of(float depth, uint previous) {
    bool fixed_ranges = params.group_depth > 0.0;
    float low = fixed_ranges ? 0.0 : history.range_low;
    float width = fixed_ranges ? params.group_depth : (history.range_high - history.range_low) / float(params.group_count);
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
    if (first >= params.spheres) {
        return;
    }
    uvec2 at = list_counts[gl_GlobalInvocationID.x];
    for (uint slot = first; slot < min(first + LIST_RUN, params.spheres); ++slot) {
        uint group = 0u;
        if (is_live(spheres[slot])) {
            vec4 view_sphere = view_spheres[slot];
            group = group_of(view_sphere.z, params.frames == 0u ? 0u : groups[slot]);
            live_list[at.x++] = slot;
            if (is_visible(view_sphere)) {
                visible_list[at.y++] = slot;
            }
        }
        groups[slot] = group;
    }
}
