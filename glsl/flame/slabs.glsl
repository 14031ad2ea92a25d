// Slabs of depth, in each of which the hottest sprite gives the colour. Every repetition has them elsewhere: two sprites share one the less often the
// farther they are apart, and the nearest slab's border is nowhere to be seen.
struct Slabs {
    float per_metre;  // 0: depths themselves
    float begin;      // of the repetition, in slabs: multiples of the golden ratio, which fill the range evenly
};

Slabs slabs_of(uint repetition) {
    uint turned = EMISSION == 1u ? (repetition + 1u) * 0x9e3779b9u : 0u;
    return Slabs(params.slabs, float(turned >> 8u) * 5.9604645e-8);
}

// What orders sprites before their heat does: their slab, or their depth. No sprite that is nearer has a larger one.
uint order_of(float depth, Slabs slabs) {
    float slab = min(max(depth, 0.0) * slabs.per_metre + slabs.begin, 2e9);
    return EMISSION == 1u && slabs.per_metre > 0.0 ? uint(slab) : floatBitsToUint(depth);
}
