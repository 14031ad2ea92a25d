// A render particle on the screen.
#include "draws.glsl"

// Places in the mask's levels: texels a pixel, and what `draw_mask` has chosen.
struct Sprite {
    vec2 at;       // centre in pixels
    float z;       // view depth
    float scale;   // texels of the mask's level a pixel
    uint texel;    // variant << 16 | place within each texel's sorted alphas
    bool exists;   // ahead of near, before far, and not lost below a pixel
};

// `origin`: the pixel that positions are relative to.
Sprite make_sprite(vec4 view, vec4 centre, vec4 slope, uint key, uint k, uint repetition, vec2 origin, uint level) {
    uint particle_word = pcg(k + key);
    uint word = draw_word(particle_word, repetition);
    vec3 offset = params.space.x * draw_offset(word, particle_word, repetition);
    vec3 in_view = vec3(dot(params.right.xyz, offset), dot(params.up.xyz, offset), dot(params.forward.xyz, offset));
    // Near the camera there is no slope, and all of the position is an offset.
    vec3 from = in_view + (slope.z == 1.0 ? view.xyz : vec3(0.0));
    float z = view.z + in_view.z;
    Sprite sprite;
    sprite.z = z;
    sprite.exists = z >= params.lens.z && z <= params.lens.w;
    float per_metre = params.focal.x / max(z, params.lens.z);
    vec2 across = vec2(from.x - slope.x * in_view.z, slope.y * in_view.z - from.y);
    sprite.at = (centre.xz - origin) + centre.yw + per_metre * across;
    float half_side = 0.5 * params.space.y * ((params.flags.w & 1u) != 0u ? 1.0 : per_metre);
    // A sprite below a pixel is a pixel that passes as often as it would have covered the centre.
    float side = min(2.0 * half_side, 1.0);
    float fill = side * side;
    sprite.scale = float(MASK_SIDE >> level) * 0.5 / max(half_side, 0.5);
    uint mask_word = pcg(word + 3u);
    uint variant = ((mask_word >> 16u) * params.draw.y) >> 16u;
    float share = float(mask_word & 0xffffu) * 1.52587890625e-5;
    sprite.exists = sprite.exists && share < fill;
    uint place = uint(min(share / max(fill, 1e-30), 0.99999994) * float(1u << (2u * level)));
    sprite.texel = variant << 16u | place;
    return sprite;
}
