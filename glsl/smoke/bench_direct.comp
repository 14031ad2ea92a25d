// The masked Gaussian by its definition: one two-dimensional sum a pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench_masked.glsl"
layout(std430, binding = 3) writeonly buffer Smooth { float smooth_luminance[]; };

void main() {
    ivec2 at = own_pixel();
    if (!is_in_picture(uvec2(at))) {
        return;
    }
    uint id = pixel_id(pixel_at(at));
    float sum = 0.0;
    float total = 0.0;
    if (id != 0u) {
        int r = window();
        ivec2 low = max(at - r, ivec2(0));
        ivec2 high = min(at + r, ivec2(params.size) - 1);
        for (int y = low.y; y <= high.y; ++y) {
            float row_sum = 0.0;
            float row_total = 0.0;
            for (int x = low.x; x <= high.x; ++x) {
                uint pixel = pixel_at(ivec2(x, y));
                float weight = pixel_id(pixel) == id ? weights[abs(x - at.x)] : 0.0;
                row_sum += weight * pixel_luminance(pixel);
                row_total += weight;
            }
            sum += weights[abs(y - at.y)] * row_sum;
            total += weights[abs(y - at.y)] * row_total;
        }
    }
    smooth_luminance[pixel_index(uvec2(at))] = id != 0u ? sum / total : 0.0;
}
