// View depth of what the mesh hides: that of the nearest of a pixel's four samples, where enough of them see the mesh.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1) uniform texture2D sampled_depth;
layout(std430, binding = 2) writeonly buffer Surface { float surface[]; };

const uint LEAST = 2u;  // samples that make a pixel one of the mesh's

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(params.image.xy)))) {
        return;
    }
    float nearest = 0.0;
    uint count = 0u;
    for (int i = 0; i < 4; ++i) {
        float nearness = texelFetch(sampled_depth, 2 * pixel + ivec2(i & 1, i >> 1), 0).x;
        nearest = max(nearest, nearness);
        count += nearness > 0.0 ? 1u : 0u;
    }
    surface[uint(pixel.y) * params.image.x + uint(pixel.x)] =
        count >= LEAST ? params.lens.x / nearest : uintBitsToFloat(0x7f800000u);
}
