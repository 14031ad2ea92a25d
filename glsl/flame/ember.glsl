// What of a pixel an ember covers: a disc, antialiased; one that is smaller than a pixel is as pale as it is small. Before it may
// be the scene, and the fire that it flies out of.
#include "params.glsl"
#include "common/fragment.glsl"
layout(constant_id = 2) const uint HAS_SCENE = 0;
layout(constant_id = 3) const uint SPREADS = 0;  // 1: tiles without fire are shown, too
layout(std430, binding = 5) readonly buffer TileShown { uint tile_shown[]; };
layout(std430, binding = 6) readonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 7) readonly buffer Scene { float scene[]; };
layout(std430, binding = 8) readonly buffer TileFire { uint tile_fire[]; };
layout(location = 0) in Ember {
#include "ember_block.glsl"
} ember;
#include "ember_shape.glsl"

float ember_share() {
    uvec2 at = pixel_of(gl_FragCoord.xy, params.corner, params.size);
    uint pixel = pixel_index(at);
    vec2 way = vec2(at) + 0.5 - ember.middle;
    float radius = max(ember.radius, LEAST_RADIUS);
    float small = ember.radius / radius;
    float share = small * small * clamp(radius + 0.5 - length(way), 0.0, 1.0);
    // Pictures of tiles that show no fire have not been made.
    uint tile = at.y / TILE * params.tiles.x + at.x / TILE;
    if ((SPREADS != 0u ? tile_shown[tile] : tile_fire[tile]) != 0u) {
        share *= 1.0 - picture[pixel].a;
    }
    if (HAS_SCENE != 0u && scene[pixel] < ember.depth) {
        share = 0.0;
    }
    if (share <= 0.0) {
        discard;
    }
    return share;
}
