// Exact ray-sphere intersection; the sphere's slot and group, or, with the mask "soft", the group of what is seen itself; and
// its exact depth.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "view.glsl"
#include "mask.glsl"
#include "coordinate.glsl"
layout(location = 0) flat in vec4 view_sphere;
layout(location = 1) flat in uint code;
layout(location = 2) flat in vec2 ranges;  // start and number a metre
layout(location = 0) out uint seen;
layout(depth_less) out float gl_FragDepth;

void main() {
    float depth;
    vec3 normal;
    bool hit = hit_sphere(pixel_ray(gl_FragCoord.xy), view_sphere, depth, normal);
    if (!(hit && depth >= params.near && depth <= params.far)) {
        discard;
    }
    gl_FragDepth = params.near / depth;
    seen = SOFT ? code & ~GROUP_MASK | group_at(Ranges(ranges.x, ranges.y), depth) : code;
}
