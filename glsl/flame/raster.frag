// The alpha test of a sprite; what passes leaves its row and depth.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "params.glsl"
layout(binding = 4, r32f) uniform readonly image2D levels;
layout(std430, binding = 5) readonly buffer Scene { float scene[]; };
layout(std430, binding = 2) readonly buffer ControlBuffer { Control control; };
layout(constant_id = 5) const uint HAS_SCENE = 0;  // 1: the scene's depth occludes
layout(location = 0) flat in vec4 place;
layout(location = 1) flat in uvec4 sprite;
layout(location = 2) flat in vec2 stretch;
layout(location = 0) out uvec2 winner;
#include "../common/bits.glsl"
#include "../common/random.glsl"
#include "common/fragment.glsl"
#include "depth_range.glsl"
#include "mask_value.glsl"
#include "sprite_stretch.glsl"

void main() {
    uint level = sprite.w;
    vec2 scale = place.w * vec2(1.0, params.squash);
    vec2 t = mask_way(gl_FragCoord.xy - place.xy, stretch, params.squash) * place.w + 0.5 * float(MASK_SIDE >> level);
    Look look = begin_look(t.x, sprite.y, level, scale);
    float value = mask_value(look, t.y);
    if (has_octaves(look)) {
        value = detailed(look, t.y, value);
    }
    bool passes = value > 0.0 && uintBitsToFloat(sprite.z) * value >= params.threshold;
    if (HAS_SCENE == 1u) {
        passes = passes && place.z < from_base(scene[pixel_index(pixel_of(gl_FragCoord.xy, uvec2(0u), params.size))]);
    }
    if (!passes) {
        discard;
    }
    winner = uvec2(sprite.x, floatBitsToUint(place.z));
}
