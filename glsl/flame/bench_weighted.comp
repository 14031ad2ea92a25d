// Weighted blended order-independent transparency (McGuire and Bavoil 2013): the mean of the colours, weighed by opacity and depth, times what
// all of them together hide. The weight is their equation 10, a cubic in depth; depth runs from 0 to 1 over what the frame shows, which suits it best.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "bench_blend.glsl"

void main() {
    note_rows();
    Pixel pixel = own_pixel();
    vec2 range = depth_range();
    vec4 sum = vec4(0.0);
    float left = 1.0;
    uint words = (params.particle_count + 31u) / 32u;
    for (uint word = 0u; word < words; ++word) {
        for (uint bits = present[pixel.block][word]; bits != 0u; bits &= bits - 1u) {
            uint row = 32u * word + uint(findLSB(bits));
            vec4 one = fog(row, pixel.ray);
            float nearness = clamp((range.y - particles[row].depth) / max(range.y - range.x, 1e-30), 0.0, 1.0);
            float weight = one.a * max(1e-2, 3e3 * nearness * nearness * nearness);
            sum += weight * one.a * vec4(one.rgb, 1.0);
            left -= left * one.a;
        }
    }
    if (pixel.inside) {
        blended[pixel.at] = vec4((1.0 - left) * sum.rgb / max(sum.a, 1e-30), 1.0 - left);
    }
}
