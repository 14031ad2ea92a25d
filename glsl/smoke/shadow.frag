// Exact depth of a sphere as the light sees it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "map_near.glsl"
layout(push_constant) uniform ShadowConstants { uint face; float texels; } constants;
layout(location = 0) flat in vec4 light_sphere;

void main() {
    vec2 at = gl_FragCoord.xy / constants.texels;
    vec3 c = light_sphere.xyz;
    float r = light_sphere.w;
    if (params.is_point_light == 0u) {
        vec2 across = at - c.xy;
        float inside = r * r - dot(across, across);
        if (inside < 0.0) {
            discard;
        }
        gl_FragDepth = clamp(c.z + sqrt(inside), 0.0, 1.0);
        return;
    }
    vec3 ray = vec3(2.0 * at - 1.0, 1.0);
    float a = dot(ray, ray);
    float closest = dot(ray, c) / a;
    vec3 across = c - closest * ray;
    float inside = r * r - dot(across, across);
    float front = closest - sqrt(max(inside, 0.0) / a);
    float near = map_near();
    if (inside < 0.0 || front < near) {
        discard;
    }
    gl_FragDepth = near / front;
}
