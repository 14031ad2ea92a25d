// Where the rasteriser sees pixel clip coordinates: nearer is larger, and nothing is too far unless views are orthographic.
#include "depths.glsl"

vec4 position_of(vec3 clip) {
    float w = widening(clip.z);
    precise vec2 at = 2.0 * clip.xy / vec2(params.size) - w;
    return vec4(at, params.is_orthographic != 0u ? nearness_of(clip.z) : params.near, w);
}

// The same of a place in pixels, at a depth.
vec4 position_at(vec2 place, float depth) {
    return position_of(vec3(place * widening(depth), depth));
}
