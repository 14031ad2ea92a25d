// Where in a sprite that is drawn out a pixel lies.
#include "stretch.glsl"

layout(constant_id = 8) const uint STRETCHED = 0;  // 1: sprites are drawn out along their motion

// The way from a sprite's centre to a pixel, in pixels across, as it was before the sprite was drawn out.
vec2 mask_way(vec2 pixels, vec2 stretch, float squash) {
    vec2 way = pixels * vec2(1.0, squash);
    vec2 back = drawn_back(way, vec2(stretch.x, -stretch.y));
    return mix(way, back, bvec2(STRETCHED == 1u));
}
