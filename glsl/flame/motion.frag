// Motion vectors of the fire, where it is most of a pixel: what that shows is at its mean depth, and has moved as its particles have in the
// mean.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/motion.glsl"
#include "common/share.glsl"
#include "common/fragment.glsl"
#extension GL_EXT_samplerless_texture_functions : require
layout(std430, binding = 2) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 3) readonly buffer Nearest { float nearest_depths[]; };
layout(binding = 4) uniform texture2D displacements;
layout(location = 0) out vec4 motion;

void main() {
    uvec2 at = pixel_of(gl_FragCoord.xy, params.corner, params.size);
    uint index = pixel_index(at);
    // Of what smoothing alone has filled no depth is known.
    if (picture[index].a < LEAST_SHARE || !is_finite(nearest_depths[index])) {
        discard;
    }
    vec3 steps = vec3(0.0);
    if (constants.moves != 0u) {
        vec4 sum = texelFetch(displacements, ivec2(at), 0);
        vec3 world = sum.w > 0.0 ? sum.xyz / sum.w : vec3(0.0);
        steps = vec3(dot(params.camera.right.xyz, world), dot(params.camera.up.xyz, world), dot(params.camera.forward.xyz, world));
    }
    float z = nearest_depths[index];
    vec2 slope = ray_at(vec2(at) + 0.5);
    motion = vec4(motion_of(slope, vec3(slope * widening(z), z), steps), 0.0, 0.0);
}
