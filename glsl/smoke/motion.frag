// Motion vectors of the smoke: what a pixel shows moves with its sphere, unless more of it shows what covers it in part.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "group.glsl"
#include "screen.glsl"
#include "view.glsl"
#include "edges.glsl"
#include "../common/host_depth.glsl"
#include "../common/motion.glsl"
#include "common/share.glsl"
#include "common/fragment.glsl"
layout(binding = 2, r32ui) uniform readonly uimage2D seen;
layout(std430, binding = 3) readonly buffer Depth { float depth[]; };
layout(std430, binding = 4) readonly buffer Moved { vec4 moved[]; };  // metres since the frame before, by sphere; w: unused
layout(std430, binding = 5) readonly buffer Edges { Edge edges[]; };
layout(location = 0) out vec4 motion;

void main() {
    uvec2 at = pixel_of(gl_FragCoord.xy, params.corner, params.size);
    uint code = imageLoad(seen, ivec2(at)).x;
    if (code == 0u) {
        discard;
    }
    uint index = pixel_index(at);
    float z = depth[index];
    if (constants.has_edges != 0u && z > edges[index].depth && 1.0 - colour_of(edges[index]).a < LEAST_SHARE) {
        discard;
    }
    Ray ray = pixel_ray(vec2(at) + 0.5);
    vec3 steps = vec3(0.0);
    if (constants.moves != 0u) {
        vec3 world = moved[(code >> GROUP_BITS) - 1u].xyz;
        steps = vec3(dot(params.camera.right.xyz, world), dot(params.camera.up.xyz, world), dot(params.camera.forward.xyz, world));
    }
    vec2 slope = params.is_orthographic != 0u ? ray.from.xy : ray.way.xy;
    motion = vec4(motion_of(slope, ray.from + z * ray.way, steps), 0.0, 0.0);
    gl_FragDepth = host_depth(z);
}
