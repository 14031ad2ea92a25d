// The quad that each visible sphere is drawn with, in normalised device coordinates: the bounds of its perspective image,
// less the blocks at its sides in which it is hidden; the whole screen if the eye plane cuts it.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const bool SKIPPING = true;  // off only to prove that leaving hidden blocks out changes nothing
#include "params.glsl"
#include "bounds.glsl"
layout(local_size_x = LIVE_LANES) in;
layout(std430, binding = 1) readonly buffer ViewSpheres { vec4 view_spheres[]; };
layout(std430, binding = 2) readonly buffer Visible { uint visible_list[]; };
layout(std430, binding = 3) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 4) readonly buffer Occlusion { uint occlusion[]; };
layout(std430, binding = 5) writeonly buffer Quads { vec4 quads[]; };

vec4 unhidden(vec4 bounds, float nearest) {
    float side = float(params.occlusion_side);
    ivec2 first = ivec2(clamp(floor(bounds.xy / side), vec2(0.0), vec2(params.occlusion_blocks) - 1.0));
    ivec2 last = ivec2(clamp(floor(bounds.zw / side), vec2(0.0), vec2(params.occlusion_blocks) - 1.0));
    ivec2 low = last + 1;
    ivec2 high = first - 1;
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            if (nearest <= uintBitsToFloat(occlusion[uint(y) * params.occlusion_blocks.x + uint(x)])) {
                low = min(low, ivec2(x, y));
                high = max(high, ivec2(x, y));
            }
        }
    }
    return vec4(max(bounds.xy, vec2(low) * side), min(bounds.zw, vec2(high + 1) * side));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= control.visible) {
        return;
    }
    vec4 sphere = view_spheres[visible_list[index]];
    vec4 bounds = vec4(0.0, 0.0, params.size);
    if (is_bounded(sphere)) {
        // A tenth of a pixel: devices may snap corners to sixteenths.
        vec4 all_of_it = pixel_bounds(sphere) + vec4(-0.1, -0.1, 0.1, 0.1);
        bounds = SKIPPING ? unhidden(all_of_it, sphere.z - sphere.w) : all_of_it;
        bounds = clamp(bounds, vec4(0.0), vec4(params.size, params.size));
        bounds.zw = max(bounds.xy, bounds.zw);
    }
    quads[index] = 2.0 * bounds / vec4(params.size, params.size) - 1.0;
}
