// One screen-aligned quad a visible sphere. Depth is reversed: near / view depth, nothing at 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "group.glsl"
layout(std430, binding = 1) readonly buffer ViewSpheres { vec4 view_spheres[]; };
layout(std430, binding = 2) readonly buffer Visible { uint visible_list[]; };
layout(std430, binding = 3) readonly buffer Groups { uint groups[]; };
layout(std430, binding = 4) readonly buffer Quads { vec4 quads[]; };
layout(std430, binding = 5) readonly buffer ControlBuffer { Control control; };
layout(location = 0) flat out vec4 view_sphere;
layout(location = 1) flat out uint code;
layout(location = 2) flat out vec2 ranges;  // of depth: start and number a metre

void main() {
    uint slot = visible_list[gl_InstanceIndex];
    view_sphere = view_spheres[slot];
    code = (slot + 1u) << GROUP_BITS | groups[slot];
    ranges = vec2(control.group_start, control.groups_per_metre);
    // Nothing of the sphere is nearer than its quad: fragments may be rejected before they are shaded.
    float front = max(view_sphere.z - view_sphere.w, params.near);
    float nearest = min(params.near / front * 1.00001, 1.0);
    vec4 quad = quads[gl_InstanceIndex];
    gl_Position = vec4(mix(quad.xy, quad.zw, vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1)), nearest, 1.0);
}
