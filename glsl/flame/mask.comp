// Alpha of the sprites: a cone times noise (Perlin 2002), one texture a variant.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/random.glsl"
#include "../common/noise.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) writeonly buffer Mask { float mask[]; };
layout(binding = 2, r32f) uniform writeonly image2D levels;

void main() {
    uint index = gl_GlobalInvocationID.x;
    uint variant = index / (MASK_SIDE * MASK_SIDE);
    if (variant >= params.variants) {
        return;
    }
    uvec2 texel = uvec2(index % MASK_SIDE, index / MASK_SIDE % MASK_SIDE);
    uint seed = params.seed;
    // Between the lattice planes, where noise is 0 at the corners of cells.
    uvec3 slice = uvec3(hash(seed, variant, 0u, 0u), hash(seed, variant, 0u, 1u), hash(seed, variant, 0u, 2u)) >> 24u;
    float between = 0.25 + 0.5 * unit(hash(seed, variant, 0u, 3u));
    vec2 share = (vec2(texel) + 0.5) / float(MASK_SIDE);
    vec2 u = 2.0 * share - 1.0;
    precise float cone = max(1.0 - sqrt(u.x * u.x + u.y * u.y), 0.0);
    precise float bumps = 0.5 + 0.5 * noise(vec3(NOISE_CELLS * share + vec2(slice.xy), float(slice.z) + between));
    precise float alpha = clamp(cone * bumps, 0.0, 1.0);
    mask[index] = alpha;
    imageStore(levels, ivec2(texel.x, variant * MASK_SIDE + texel.y), vec4(alpha));
}
