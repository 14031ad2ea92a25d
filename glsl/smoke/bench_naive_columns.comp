// The wrong separable form, second pass: columns under the mask of their own centre. A row whose pixel straight above
// or below has another group is lost whole, and with it the pixels of the right group beside it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench_masked.glsl"
layout(std430, binding = 3) readonly buffer RowSums { vec2 row_sums[]; };
layout(std430, binding = 4) writeonly buffer Smooth { float smooth_luminance[]; };

void main() {
    ivec2 at = own_pixel();
    if (!is_in_picture(uvec2(at))) {
        return;
    }
    uint id = pixel_id(pixel_at(at));
    vec2 sums = vec2(0.0, 1.0);
    if (id != 0u) {
        sums = vec2(0.0);
        int r = window();
        for (int y = max(at.y - r, 0); y <= min(at.y + r, int(params.size.y) - 1); ++y) {
            float weight = pixel_id(pixel_at(ivec2(at.x, y))) == id ? weights[abs(y - at.y)] : 0.0;
            sums += weight * row_sums[pixel_index(uvec2(at.x, y))];
        }
    }
    smooth_luminance[pixel_index(uvec2(at))] = sums.x / sums.y;
}
