// Fog composited front to back in the exact order of the centres' depths: that of all pixels, so it is that of each of them.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "bench_blend.glsl"
layout(std430, binding = 8) readonly buffer Ranks { uint ranks[]; };
layout(std430, binding = 9) readonly buffer Order { uint order[]; };

void main() {
    clear_present();
    for (uint level = 0u; level < params.cell_level_count; ++level) {
        uvec2 list = list_range(own_tile(), level);
        for (uint at = list.x + gl_LocalInvocationID.x; at < list.y; at += TILE_PIXELS) {
            note(entries[at], ranks[entries[at]]);
        }
    }
    barrier();
    Pixel pixel = own_pixel();
    vec3 mean = vec3(0.0);
    float left = 1.0;
    uint words = (params.particle_count + 31u) / 32u;
    for (uint word = 0u; word < words && left > OPAQUE; ++word) {
        for (uint bits = present[pixel.block][word]; bits != 0u; bits &= bits - 1u) {
            vec4 one = fog(order[32u * word + uint(findLSB(bits))], pixel.ray);
            mean += left * one.a * one.rgb;
            left -= left * one.a;
        }
    }
    if (pixel.inside) {
        blended[pixel.at] = vec4(mean, 1.0 - left);
    }
}
