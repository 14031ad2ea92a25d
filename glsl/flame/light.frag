// How much the fire brightens what is in the scene: its colour, half of it at the edge of the fire, less with the squared distance.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "common/fragment.glsl"
layout(std430, binding = 1) readonly buffer Scene { float scene[]; };
layout(std430, binding = 2) readonly buffer LampBuffer { Lamp lamp; };
layout(location = 0) out vec4 brighter;

void main() {
    vec2 at = gl_FragCoord.xy - vec2(params.corner);
    float depth = scene[pixel_index(pixel_of(gl_FragCoord.xy, params.corner, params.size))];
    if (!(depth < uintBitsToFloat(INFINITY_BITS))) {
        discard;
    }
    vec3 away = vec3(widening(depth) * ray_at(at), depth - lamp.base) - vec3(lamp.middle, lamp.depth);
    brighter = vec4(vec3(lamp.colour[0], lamp.colour[1], lamp.colour[2]) / (1.0 + dot(away, away) / lamp.squared_width), 0.0);
}
