// Alpha of the mask where a sprite meets a column of pixels.
#include "mask_place.glsl"

const uint MINIFIED = 0u;   // how the mask is looked up: the nearest texel of a level,
const uint MAGNIFIED = 1u;  // between texels of level 0,
const uint EITHER = 2u;     // or what the level asks for

layout(constant_id = 4) const uint LOOK_UP = 0;
layout(constant_id = 6) const uint OCTAVES = 0;  // of finer noise where the mask is magnified
#include "octaves.glsl"

// What all pixels of a column have in common. Coordinates are texels of the mask's level from the sprite's corner.
struct Look {
    uint level;
    int last;      // texel of the level along a side
    ivec2 corner;  // of the sprite's values in `levels`
    int column;    // of the value there that the column has
    float x;
    bool inside;   // whether it is in one
    float footprint;  // texels a pixel
    uint word;     // of the variant's finer noise
};

// The same in another column.
Look moved(Look look, float x) {
    int column = int(floor(x));
    look.column = look.corner.x + (column & look.last);
    look.x = x;
    look.inside = uint(column) <= uint(look.last);
    return look;
}

// `scale`: texels a pixel across and down.
Look begin_look(float x, uint texel, uint level, vec2 scale) {
    Look look;
    look.level = level;
    look.last = int(MASK_SIDE >> level) - 1;
    look.corner = mask_place(level, uvec2(0u), texel >> 16u, texel & 0xffffu);
    look.footprint = max(scale.x, scale.y);
    look.word = OCTAVES == 0u ? 0u : pcg(OCTAVE_KEY + pcg((texel >> 16u) + pcg(params.seed)));
    return moved(look, x);
}

// Between four texels; 0 outside of the disc.
float magnified(Look look, float y) {
    vec2 at = vec2(look.x, y) - 0.5;
    vec2 low = floor(at);
    vec2 f = at - low;
    ivec2 a = look.corner + clamp(ivec2(low), ivec2(0), ivec2(look.last));
    ivec2 b = look.corner + clamp(ivec2(low) + 1, ivec2(0), ivec2(look.last));
    float upper = mix(imageLoad(levels, a).r, imageLoad(levels, ivec2(b.x, a.y)).r, f.x);
    float lower = mix(imageLoad(levels, ivec2(a.x, b.y)).r, imageLoad(levels, b).r, f.x);
    vec2 u = vec2(look.x, y) * (2.0 / float(MASK_SIDE)) - 1.0;
    return mix(0.0, mix(upper, lower, f.y), dot(u, u) < 1.0);
}

// Whether a sprite is magnified so that there is finer noise: its values are then those of `detailed`.
bool has_octaves(Look look) {
    return all(bvec3(OCTAVES != 0u, look.level == 0u, look.footprint < 0.25 * FIRST_OCTAVE));
}

// A value with the finer noise: as high as the cone, like the rest of the noise, and no higher than the mask is anywhere.
float detailed(Look look, float y, float value) {
    vec2 u = vec2(look.x, y) * (2.0 / float(MASK_SIDE)) - 1.0;
    float cone = max(1.0 - sqrt(dot(u, u)), 0.0);
    value += cone * octaves_at(look.word, vec2(look.x, y), look.footprint);
    return mix(0.0, clamp(value, 0.0, min(cone, params.max_alpha)), dot(u, u) < 1.0);
}

float mask_value(Look look, float y) {
    if (LOOK_UP == MAGNIFIED || (LOOK_UP == EITHER && look.level == 0u)) {
        return magnified(look, y);
    }
    int row = int(floor(y));
    float alpha = imageLoad(levels, ivec2(look.column, look.corner.y + (row & look.last))).r;
    return mix(0.0, alpha, all(bvec2(look.inside, uint(row) <= uint(look.last))));
}
