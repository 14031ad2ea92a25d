// Motion vectors of the mesh, where it is most of a pixel: what that shows is on its trajectory at k', and was one frame earlier where that
// is at k' - 1. Trajectories are of one picture, whose jitter falls out.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
layout(constant_id = 1) const uint DEPTH = 0;  // 1: the host has a depth
#include "params.glsl"
#include "../common/half.glsl"
#include "../common/host_depth.glsl"
#include "common/share.glsl"
#include "common/fragment.glsl"
layout(push_constant) uniform BeforeConstants {
    vec2 jitter_change;  // how much farther frame i + 1 is moved than frame i - 1, in pixels
    uint has_before;     // there is a frame i - 1
} constants;
layout(std430, binding = 1) readonly buffer Splines { Piece splines[]; };
layout(std430, binding = 2) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 3) readonly buffer Triangles { uvec4 triangles[]; };
#include "edges.glsl"
#include "curve.glsl"
#include "fragment.glsl"
#include "visible.glsl"
layout(location = 0) out vec4 motion;

bool is_divided() {
    return SCREEN == 0u && params.is_orthographic == 0u;
}

// How far a point is in frame i - 1 from where it is in frame i, as splines have it.
vec3 off_before(uint point) {
    vec3 before = clip[point].xyz;
    vec3 now = clip[params.points + point].xyz;
    before.xy += constants.jitter_change * widening(before.z);
    now.xy += params.jitter_change * widening(now.z);
    vec3 off = before - now;
    vec2 moved = (off.xy - now.xy / now.z * off.z) / before.z;
    return vec3(SCREEN == 1u && params.is_orthographic == 0u ? moved : off.xy, off.z);
}

// How far a point is from where it is in frame i. Before that, where pieces do not reach, by the cubic that goes on as smoothly as a spline
// and through frame i - 1; straight if there is none. What rests there rests.
vec3 off_at(uint point, float time) {
    Offset at = offset_at(point, point, 0u, time);
    bool is_beyond = time < 0.0 && params.segment_count == params.segments_ahead;
    if (!is_beyond || constants.has_before == 0u || !(params.is_orthographic != 0u || clip[point].z >= params.near)) {
        return at.off;
    }
    vec3 before = off_before(point);
    float length_of = params.segments[0].end - params.segments[0].begin;
    vec3 half_bend = splines[point].bend_begin.xyz * (0.5 / (length_of * length_of));
    vec3 rest = half_bend - at.slope - before;
    return before == vec3(0.0) ? vec3(0.0) : ((rest * time + half_bend) * time + at.slope) * time;
}

void main() {
    ivec2 pixel = ivec2(pixel_of(gl_FragCoord.xy, params.corner, params.size));
    float nearest = 0.0;
    float share = 0.0;
    ivec2 seen = ivec2(0);
    for (int i = 0; i < 4; ++i) {
        ivec2 at = sample_of(pixel, i);
        float nearness = shown_nearness(pixel, at);
        seen = nearness > nearest ? at : seen;
        nearest = max(nearest, nearness);
        share += nearness > 0.0 ? 0.25 : 0.0;
    }
    if (share < LEAST_SHARE) {
        discard;
    }
    vec2 place = 0.5 * (vec2(seen) + 0.5);
    Fragment fragment = fragment_at(texelFetch(sampled, seen, 0).x, place);
    float depth = 0.0;
    vec3 change = vec3(0.0);
    for (uint i = 0u; i < 3u; ++i) {
        uint point = fragment.base[i];
        vec3 off = off_at(point, fragment.moved);
        depth += fragment.barycentrics[i] * (splines[point].origin.z + off.z);
        change += fragment.barycentrics[i] * (off_at(point, fragment.moved - 1.0) - off);
    }
    vec2 vector = is_divided() ? (change.xy - place * change.z) / max(depth + change.z, params.near) : change.xy;
    motion = vec4(clamp(vector, -MOST_HALF, MOST_HALF), 0.0, 0.0);
    gl_FragDepth = DEPTH == 1u ? host_depth(drawn_depth_of(pixel)) : 0.0;
}
