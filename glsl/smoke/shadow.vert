// One quad a live sphere, as the light sees it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 1) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 2) readonly buffer Live { uint live_list[]; };
layout(std430, binding = 3) readonly buffer ControlBuffer { Control control; };
layout(push_constant) uniform ShadowConstants { uint face; float texels; } constants;
layout(location = 0) flat out vec4 light_sphere;
#include "light.glsl"
#include "light_map.glsl"

void main() {
    vec4 sphere = spheres[live_list[gl_InstanceIndex]];
    vec2 corner = 2.0 * vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) - 1.0;
    float margin = 2.0 / constants.texels;
    if (!is_point_light()) {
        vec4 frame = map_frame();
        light_sphere = vec4((in_light_space(sphere.xyz) - frame.xyz) / frame.w, sphere.w / frame.w);
        vec2 at = 2.0 * light_sphere.xy - 1.0 + corner * (2.0 * light_sphere.w + margin);
        gl_Position = vec4(at, 0.0, 1.0);
        return;
    }
    vec3 c = on_face(sphere.xyz - params.light.xyz, constants.face);
    light_sphere = vec4(c, sphere.w);
    vec4 bounds = vec4(-1.0, -1.0, 1.0, 1.0);
    if (c.z + sphere.w <= 0.0 || dot(c, c) <= sphere.w * sphere.w) {
        bounds = vec4(2.0);
    } else if (c.z > sphere.w * 1.001) {
        vec2 across = tangent_range(c.x, c.z, sphere.w);
        vec2 down = tangent_range(c.y, c.z, sphere.w);
        bounds = clamp(vec4(across.x, down.x, across.y, down.y) + vec4(-margin, -margin, margin, margin), -1.0, 1.0);
    }
    gl_Position = vec4(mix(bounds.xy, bounds.zw, 0.5 * corner + 0.5), 0.0, 1.0);
}
