// The width of ink, over samples: the strongest of those near enough, fading over the last sample.
#include "toon/ink_width.glsl"

float line_of(ivec2 at, int reach) {
    ivec2 size = 2 * ivec2(params.size);
    ivec2 low = max(at - reach, ivec2(0));
    ivec2 high = min(at + reach, size - 1);
    float opacity = 0.0;
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            float share = ink_share(toon.ink_width, length(vec2(ivec2(x, y) - at)));
            opacity = max(opacity, share * line_near(ivec2(x, y)));
        }
    }
    return opacity;
}
