// The mask's level of this frame: the coarsest whose texels are not larger than a pixel at the nearest particle.
uint mask_level() {
    float pixels = params.is_in_pixels != 0u ? params.sprite_size : params.sprite_size * max(params.focal_length.x, params.focal_length.y) / widening(uintBitsToFloat(control.nearest));
    uint level = 0u;
    while (level < MASK_LEVELS - 1u && pixels <= float(MASK_SIDE >> (level + 1u))) {
        ++level;
    }
    return level;
}

// The share of a sprite's half side that can pass for a particle of alpha `alpha` (A is at most 1 - |u|), at a level.
float reach_of(float alpha, uint level) {
    float needed = params.threshold / alpha;
    float share = 1.0 - max(needed, 0.0) + 2.0 / float(MASK_SIDE >> level) + 1e-4;
    return params.is_skipping != 0u && alpha > 0.0 ? clamp(share, 0.0, 1.0) : 1.0;
}
