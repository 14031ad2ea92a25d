// From sums to the picture: mean and variance of the repetitions, or what `expected` found of them; exposure.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const uint KEEP_LAYERS = 0;
layout(constant_id = 1) const uint EXPECTED = 0;  // 1: sums hold the integral, in shares of the brightest colour
layout(constant_id = 2) const uint KEEP_DEPTH = 0;  // 1: motion vectors, or layers, are made of it
layout(constant_id = 3) const uint CEL = 0;      // 1: the picture is made of tones
layout(constant_id = 4) const uint SPREADS = 0;  // 1: tiles without fire are shown, too
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
layout(std430, binding = 9) readonly buffer TileFire { uint tile_fire[]; };
#include "sums.glsl"

// A sum of two words as a sum of two floats.
vec2 split(uint low, uint high) {
    vec2 upper = two_sum(float(high >> 16u) * 281474976710656.0, float(high & 0xffffu) * WORD);
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

struct Pixel {
    vec3 mean;      // in shares of the brightest colour
    vec3 variance;
    float coverage;
    float depth;
};

Pixel of_repetitions(uint at, float n) {
    Sum whole = load_sum(at);
    float hits = float(whole.hits);
    Pixel pixel;
    for (int c = 0; c < 3; ++c) {
        vec2 sum = split(whole.low[c], whole.high[c]);
        pixel.mean[c] = sum.x / n / LIGHT_STEPS;
        pixel.variance[c] = KEEP_LAYERS == 1u ? variance_of(sum, split(whole.square_low[c], whole.square_high[c]), n) / (LIGHT_STEPS * LIGHT_STEPS) : 0.0;
    }
    pixel.coverage = hits / n;
    pixel.depth = hits > 0.0 ? whole.depth / hits + uintBitsToFloat(control.base) : uintBitsToFloat(INFINITY_BITS);
    return pixel;
}

Pixel of_integral(uint at) {
    vec4 a = uintBitsToFloat(sums[SUM_VECTORS * at]);
    vec4 b = uintBitsToFloat(sums[SUM_VECTORS * at + 1u]);
    Pixel pixel;
    pixel.mean = a.xyz;
    pixel.variance = max(b.xyz - a.xyz * a.xyz, 0.0);
    pixel.coverage = 1.0 - a.w;
    pixel.depth = pixel.coverage > 0.0 ? b.w / pixel.coverage + uintBitsToFloat(control.base) : uintBitsToFloat(INFINITY_BITS);
    return pixel;
}

void main() {
    uint tile = occupied_tiles[gl_WorkGroupID.x];
    uvec2 corner = TILE * tile_at(tile);
    bool has_fire = SPREADS == 0u || tile_fire[tile] != 0u;
    float n = EXPECTED == 1u ? 0.0 : float(tile_repetitions[tile]);
    float brightest = uintBitsToFloat(control.brightest);
    for (uint i = gl_LocalInvocationID.x; i < TILE * TILE; i += gl_WorkGroupSize.x) {
        uvec2 place = corner + uvec2(i % TILE, i / TILE);
        if (all(lessThan(place, params.size))) {
            uint at = pixel_index(place);
            Pixel pixel = Pixel(vec3(0.0), vec3(0.0), 0.0, uintBitsToFloat(INFINITY_BITS));
            if (!has_fire) {
                // Nobody has written its sums.
            } else if (EXPECTED == 1u) {
                pixel = of_integral(at);
            } else {
                pixel = of_repetitions(at, n);
            }
            vec3 mean = pixel.mean * brightest;
            if (CEL == 0u) {
                picture[at] = vec4(params.intensity * mean, pixel.coverage);
            }
            if (KEEP_LAYERS == 1u && has_fire) {
                means[at] = vec4(mean, pixel.coverage);
                variances[at] = vec4(pixel.variance * brightest * brightest, n);
            }
            if (KEEP_DEPTH == 1u) {
                nearest_depths[at] = pixel.depth;
            }
        }
    }
}
