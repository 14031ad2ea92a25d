// The paper's way: a camera-facing quad for each render particle.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 3) readonly buffer SpriteList { uvec2 sprite_list[]; };
layout(push_constant) uniform RasterConstants { uint repetition; } constants;
layout(location = 0) flat out vec4 place;    // x, y, depth less the frame's base, texels a pixel
layout(location = 1) flat out uvec4 sprite;  // row + 1, texel, alpha, level
layout(location = 2) flat out vec2 stretch;
layout(std430, binding = 6) readonly buffer Stretches { uint stretches[]; };
#include "../common/bits.glsl"
#include "depth_range.glsl"
#include "mask_level.glsl"
#include "sprite.glsl"

void main() {
    uvec2 entry = sprite_list[gl_InstanceIndex];
    Particle particle = particles[entry.x];
    uint level = mask_level();
    stretch = stretch_of(stretches[entry.x]);
    Source source = source_of(particle, stretch, vec2(0.0));
    Sprite s = make_sprite(optics_of_frame(level), source, pcg(entry.y + particle.hash), constants.repetition);
    place = vec4(s.at, s.z, s.scale);
    // From 1 to 0, as finely as single precision tells depths apart.
    vec2 ends = depth_range();
    float nearness = depth_base() > 0.0 ? (ends.y - ends.x) / (ends.y - ends.x + s.z) : params.near / s.z;
    sprite = uvec4(entry.x + 1u, s.texel, floatBitsToUint(particle.colour.a), level);
    float half_side = s.exists ? 0.5 * float(MASK_SIDE >> level) / s.scale : 0.0;
    vec2 reach = half_side * (STRETCHED == 1u ? stretched_reach(stretch) : vec2(1.0));
    vec2 corner = s.at + reach / vec2(1.0, params.squash) * (2.0 * vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) - 1.0);
    gl_Position = vec4(2.0 * corner / vec2(params.size) - 1.0, s.exists ? nearness : 0.0, 1.0);
}
