// Blends an after-image in behind the mesh.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "behind.glsl"
layout(binding = 6) uniform texture2D ghost;
layout(binding = 7) uniform texture2D ghost_depth;
#include "ghosts.glsl"
#include "common/fragment.glsl"
layout(location = 0) out vec4 colour;

const int INK_WAYS = 16;  // directions that are looked in
const float COPY_STEP = 0.02;  // the least step of depth that has a line, as a share of the depth

// Depth of a copy at a sample, in any unit; 0 where there is none of it.
float ghost_at(ivec2 at) {
    ivec2 last = textureSize(ghost, 0) - 1;
    ivec2 place = clamp(at, ivec2(0), last);
    return texelFetch(ghost, place, 0).a > 0.0 ? 1.0 / max(texelFetch(ghost_depth, place, 0).x, 1e-30) : 0.0;
}

// Whether the line around a copy covers a sample of it: where, a line's width off, there is none of it, or what is much farther
// away than the surface leads to expect.
bool is_inked(ivec2 at) {
    float own = ghost_at(at);
    if (own == 0.0) {
        return false;
    }
    for (int way = 0; way < INK_WAYS; ++way) {
        float turn = 6.2831853 * float(way) / float(INK_WAYS);
        for (int half_way = 1; half_way <= 2; ++half_way) {
            ivec2 off = ivec2(round(0.5 * float(half_way) * constants.radius * vec2(cos(turn), sin(turn))));
            float beyond = ghost_at(at + off);
            float before = ghost_at(at - off);
            float slope = before > 0.0 ? max(own - before, 0.0) : 0.0;
            if (beyond == 0.0 || beyond - own - slope > COPY_STEP * own) {
                return true;
            }
        }
    }
    return false;
}

void main() {
    ivec2 pixel = ivec2(pixel_of(gl_FragCoord.xy, params.corner, params.size));
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 at = sample_of(pixel, i);
        if (is_behind(at, texelFetch(ghost_depth, at, 0).x)) {
            vec4 own = texelFetch(ghost, at, 0);
            if (constants.ink.w > 0.0 && is_inked(at)) {
                own.rgb = mix(own.rgb, constants.ink.rgb * own.a, constants.ink.w);
            }
            sum += 0.25 * own;
        }
    }
    colour = constants.opacity * sum;
    if (colour.a == 0.0) {
        discard;
    }
}
