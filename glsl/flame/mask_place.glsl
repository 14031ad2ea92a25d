// Where the mask's levels have the alphas below a texel: each place in their order is a picture of its own, so that neighbouring pixels of a sprite
// read neighbours.
ivec2 mask_place(uint level, uvec2 texel, uint variant, uint index) {
    uvec2 picture = uvec2(index & ((1u << level) - 1u), index >> level) * (MASK_SIDE >> level);
    return ivec2(uvec2(level, variant) * MASK_SIDE + picture + texel);
}
