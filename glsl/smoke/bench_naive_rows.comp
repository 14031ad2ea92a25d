// The wrong separable form, to measure its error: rows under the mask of the row pass's own centre.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench_masked.glsl"
layout(std430, binding = 3) writeonly buffer RowSums { vec2 row_sums[]; };

void main() {
    ivec2 at = own_pixel();
    if (!is_in_picture(uvec2(at))) {
        return;
    }
    uint id = pixel_id(pixel_at(at));
    vec2 sums = vec2(0.0);
    if (id != 0u) {
        int r = window();
        for (int x = max(at.x - r, 0); x <= min(at.x + r, int(params.size.x) - 1); ++x) {
            uint pixel = pixel_at(ivec2(x, at.y));
            float weight = pixel_id(pixel) == id ? weights[abs(x - at.x)] : 0.0;
            sums += weight * vec2(pixel_luminance(pixel), 1.0);
        }
    }
    row_sums[pixel_index(uvec2(at))] = sums;
}
