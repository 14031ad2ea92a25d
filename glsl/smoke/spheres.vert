// One screen-aligned quad a visible sphere, bounding its perspective image exactly (tangent lines from the eye, axis by
// axis); the whole screen if the eye plane cuts it. Depth is reversed: near / view depth, nothing at 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "view.glsl"
layout(std430, binding = 1) readonly buffer ViewSpheres { vec4 view_spheres[]; };
layout(std430, binding = 2) readonly buffer Visible { uint visible_list[]; };
layout(std430, binding = 3) readonly buffer Groups { uint groups[]; };
layout(location = 0) flat out vec4 view_sphere;
layout(location = 1) flat out uint code;

vec2 tangent_range(float x, float z, float r) {
    float t = sqrt(max((z - r) * (z + r) + x * x, 0.0));
    return vec2((x * t - z * r) / (z * t + x * r), (x * t + z * r) / (z * t - x * r));
}

void main() {
    uint slot = visible_list[gl_InstanceIndex];
    view_sphere = view_spheres[slot];
    vec3 c = view_sphere.xyz;
    float r = view_sphere.w;
    code = (slot + 1u) << 8 | groups[slot];
    vec4 bounds = vec4(-1.0, -1.0, 1.0, 1.0);
    if (c.z > r * 1.001) {
        vec2 across = tangent_range(c.x, c.z, r) / params.lens.x;
        vec2 down = -tangent_range(c.y, c.z, r).yx / params.lens.y;
        vec2 margin = 0.02 / vec2(params.image.xy);
        bounds = clamp(vec4(across.x, down.x, across.y, down.y) + vec4(-margin, margin), -1.0, 1.0);
    }
    // Nothing of the sphere is nearer than its quad: fragments may be rejected before they are shaded.
    float nearest = min(params.lens.z / max(c.z - r, params.lens.z) * 1.00001, 1.0);
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(mix(bounds.xy, bounds.zw, corner), nearest, 1.0);
}
