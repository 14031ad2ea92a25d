// A render particle on the screen.
#include "draws.glsl"
#include "sprite_stretch.glsl"

// Places in the mask's levels: texels a pixel, and what `draw_mask` has chosen.
struct Sprite {
    vec2 at;       // centre in pixels
    float z;       // view depth, less the frame's base
    float scale;   // texels of the mask's level a pixel across; down it is `params.squash` times as many
    uint texel;    // variant << 16 | place within each texel's sorted alphas
    bool exists;   // ahead of near, before far, and not lost below a pixel
};

// What all render particles of a frame have in common: read once, because a device may read a uniform anew in each iteration of a loop.
struct Optics {
    vec3 right;       // rows of the view rotation
    vec3 up;
    vec3 forward;
    float spread;
    float base;       // the view depth that those of particles are less
    float near;       // from there, as `far` is
    float far;
    vec2 focal;       // pixels of a slope of 1
    bool is_parallel; // orthographic: pixels of a metre
    float squash;     // pixels of a sprite across over those down
    float half_side;  // half a sprite, in metres or pixels
    bool in_pixels;
    uint variants;
    float half_mask;  // texels of half the mask's level along a side
    float places;     // alphas below one of its texels
};

Optics optics_of_frame(uint level) {
    return Optics(params.camera.right.xyz, params.camera.up.xyz, params.camera.forward.xyz, params.spread, depth_base(),
        params.near - depth_base(), params.far - depth_base(), params.focal_length,
        params.is_orthographic != 0u, params.squash,
        0.5 * params.sprite_size, params.is_in_pixels != 0u, params.variants, 0.5 * float(MASK_SIDE >> level), float(1u << (2u * level)));
}

// What render particles need of their particle.
struct Source {
    vec2 at;     // its centre in pixels
    float z;     // its view depth, less the frame's base
    vec2 slope;  // x / z and y / z; 0 where rays are parallel
    vec2 from;   // near the camera there is no slope: x and y, and `at` is the middle of the picture
    vec2 stretch;
};

// `origin`: the pixel that positions are relative to.
Source source_of(Particle particle, vec2 stretch, vec2 origin) {
    vec2 from = (particle.flags & NEAR_CAMERA) != 0u ? particle.view : vec2(0.0);
    return Source((particle.pixel - origin) + particle.pixel_fraction, particle.depth, particle.slope, from, stretch);
}

// `particle_word`: hash of the particle's id and the sample.
Sprite make_sprite(Optics optics, Source source, uint particle_word, uint repetition) {
    uint word = draw_word(particle_word, repetition);
    vec3 offset = optics.spread * draw_offset(word, particle_word, repetition);
    vec3 in_view = vec3(dot(optics.right, offset), dot(optics.up, offset), dot(optics.forward, offset));
    vec2 from = (STRETCHED == 1u ? drawn_out(in_view.xy, source.stretch) : in_view.xy) + source.from;
    float z = source.z + in_view.z;
    vec2 per_metre = optics.focal / (optics.is_parallel ? 1.0 : max(z, optics.near) + optics.base);
    vec2 across = vec2(from.x - source.slope.x * in_view.z, source.slope.y * in_view.z - from.y);
    float half_side = optics.half_side * (optics.in_pixels ? 1.0 : per_metre.x);
    // A sprite below a pixel is as large as one that passes as often as it would have covered the centre.
    float least = max(optics.squash, 1.0);
    float side = min(2.0 * half_side / least, 1.0);
    float fill = side * side;
    uint mask_word = pcg(word + 3u);
    uint variant = ((mask_word >> 16u) * optics.variants) >> 16u;
    float share = float(mask_word & 0xffffu) * 1.52587890625e-5;
    uint place = uint(min(share / max(fill, 1e-30), 0.99999994) * optics.places);
    Sprite sprite;
    sprite.at = source.at + per_metre * across;
    sprite.z = z;
    sprite.scale = optics.half_mask / max(half_side, 0.5 * least);
    sprite.texel = variant << 16u | place;
    sprite.exists = z >= optics.near && z <= optics.far && share < fill;
    return sprite;
}
