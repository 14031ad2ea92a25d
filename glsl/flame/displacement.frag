// How much a particle's displacement counts in a pixel: by its render particles, and by how near it is to the mean place of the fire seen
// there. Nowhere is that nothing: each pixel of the fire has a mean.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
#include "common/fragment.glsl"
layout(std430, binding = 5) readonly buffer Nearest { float nearest_depths[]; };
layout(location = 0) flat in vec4 centre;
layout(location = 1) flat in vec4 moved;
layout(location = 0) out vec4 sum;  // displacements by weight; weights

void main() {
    float z = nearest_depths[pixel_index(pixel_of(gl_FragCoord.xy, uvec2(0u), params.size))];
    if (!is_finite(z)) {
        discard;
    }
    vec3 way = vec3(ray_at(gl_FragCoord.xy) * widening(z), z) - centre.xyz;
    float falloff = 1.0 + dot(way, way) * centre.w;
    float weight = moved.w / (falloff * falloff);
    sum = vec4(weight * moved.xyz, weight);
}
