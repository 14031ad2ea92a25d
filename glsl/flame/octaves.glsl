// Finer noise below the mask's texels: Perlin noise in two dimensions, its gradients chosen by a hash, an octave at a time. An octave is faded out
// where its waves are narrower than four pixels, so that where the mask is not magnified there is none, and where they are broader than 32: a sprite
// is as rough whatever its size.

// One of eight directions, times a place: all are as long.
float octave_gradient(uint h, vec2 p) {
    // Nothing branches here: the loop over sprites has many of these.
    vec2 q = mix(-p, p, bvec2((h & 1u) == 0u));
    bool is_first = (h & 2u) == 0u;
    float straight = 1.4142135 * mix(q.y, q.x, is_first);
    float slanted = mix(q.x - q.y, q.x + q.y, is_first);
    return mix(slanted, straight, (h & 4u) == 0u);
}

float octave_fade(float t) {
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

float octave_noise(uint word, vec2 p) {
    vec2 low = floor(p);
    ivec2 cell = ivec2(low);
    vec2 at = p - low;
    vec2 f = vec2(octave_fade(at.x), octave_fade(at.y));
    uint upper = pcg(uint(cell.y) + word);
    uint lower = pcg(uint(cell.y + 1) + word);
    float a = octave_gradient(pcg(uint(cell.x) + upper), at);
    float b = octave_gradient(pcg(uint(cell.x + 1) + upper), at - vec2(1.0, 0.0));
    float c = octave_gradient(pcg(uint(cell.x) + lower), at - vec2(0.0, 1.0));
    float d = octave_gradient(pcg(uint(cell.x + 1) + lower), at - vec2(1.0, 1.0));
    return mix(mix(a, b, f.x), mix(c, d, f.x), f.y);
}

// All of them at a place in texels. `word`: hash of the mask's variant; `footprint`: texels a pixel. Those whose waves have 4 to 32 pixels: three of
// them, so that there is no loop.
float octaves_at(uint word, vec2 place, float footprint) {
    // The first whose waves have less than 32: a power of two above this.
    float halvings = FIRST_OCTAVE / (32.0 * footprint);
    uint first = uint(max(int(floatBitsToUint(halvings) >> 23u) - 126, 0));
    float sum = 0.0;
    [[unroll]] for (uint i = 0u; i < 3u; ++i) {
        uint octave = first + i;
        float waves = uintBitsToFloat((octave + 127u) << 23u) / FIRST_OCTAVE;
        float pixels = footprint * waves;
        float share = clamp(2.0 - 8.0 * pixels, 0.0, 1.0) * clamp(32.0 * pixels - 1.0, 0.0, 1.0);
        share = octave < OCTAVES ? share : 0.0;
        sum += share * octave_noise(pcg(octave + word), waves * place);
    }
    return OCTAVE * sum;
}
