// From sums to the picture: mean and variance of the repetitions, exposure. Where nothing was hit nothing is written but layers.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const uint KEEP_LAYERS = 0;
#include "params.glsl"
#include "../common/exact.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 2) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 3) readonly buffer Sums { uvec4 sums[]; };
layout(std430, binding = 4) readonly buffer TileRepetitions { uint tile_repetitions[]; };
layout(std430, binding = 5) writeonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 6) writeonly buffer Mean { vec4 means[]; };
layout(std430, binding = 7) writeonly buffer Variance { vec4 variances[]; };
layout(std430, binding = 8) writeonly buffer Nearest { float nearest_depths[]; };

// A sum of two words as a sum of two floats.
vec2 split(uint low, uint high) {
    vec2 upper = two_sum(float(high >> 16u) * 281474976710656.0, float(high & 0xffffu) * 4294967296.0);
    vec2 lower = two_sum(float(low >> 16u) * 65536.0, float(low & 0xffffu));
    vec2 sum = two_sum(upper.x, lower.x);
    return two_sum(sum.x, sum.y + upper.y + lower.y);
}

// Variance of one repetition, from sum and sum of squares: (squares - sum * sum / n) / (n - 1).
float variance_of(vec2 sum, vec2 squares, float n) {
    float mean = sum.x / n;
    vec2 product = two_product(sum.x, mean);
    // sum / n is mean plus this.
    vec2 back = two_product(mean, n);
    float rest = ((sum.x - back.x) - back.y + sum.y) / n;
    float low = product.y + sum.x * rest + sum.y * mean;
    vec2 difference = two_sum(squares.x, -product.x);
    return n > 1.0 ? max(difference.x + (difference.y + squares.y - low), 0.0) / (n - 1.0) : 0.0;
}

void main() {
    uint tile = occupied_tiles[gl_WorkGroupID.x];
    uvec2 corner = TILE * uvec2(tile % params.image.z, tile / params.image.z);
    float repetitions = float(tile_repetitions[tile]);
    float one = uintBitsToFloat(control.brightest) / 65535.0;
    for (uint i = gl_LocalInvocationID.x; i < TILE * TILE; i += 64u) {
        uvec2 pixel = corner + uvec2(i % TILE, i / TILE);
        if (all(lessThan(pixel, params.image.xy))) {
            uint at = pixel.y * params.image.x + pixel.x;
            uvec4 low = sums[4u * at];
            uvec4 high = sums[4u * at + 1u];
            vec2 r = split(low.x, high.x);
            vec2 g = split(low.y, high.y);
            vec2 b = split(low.z, high.z);
            vec3 mean = vec3(r.x, g.x, b.x) / repetitions * one;
            float hits = float(low.w);
            float coverage = hits / repetitions;
            picture[at] = vec4(params.light.x * mean, coverage);
            if (KEEP_LAYERS == 1u) {
                uvec4 square_low = sums[4u * at + 2u];
                uvec4 square_high = sums[4u * at + 3u];
                vec3 variance = vec3(variance_of(r, split(square_low.x, square_high.x), repetitions),
                                     variance_of(g, split(square_low.y, square_high.y), repetitions),
                                     variance_of(b, split(square_low.z, square_high.z), repetitions));
                means[at] = vec4(mean, coverage);
                variances[at] = vec4(variance * one * one, repetitions);
                nearest_depths[at] = hits > 0.0 ? uintBitsToFloat(high.w) / hits : uintBitsToFloat(FAR_AWAY);
            }
        }
    }
}
