// Where the rasteriser sees clip coordinates: depth is near / W, so that nearer is larger and nothing is too far.
vec4 position_of(vec4 clip) {
    precise vec2 at = 2.0 * clip.xy / vec2(params.image.xy) - clip.z;
    return vec4(at, params.lens.x, clip.z);
}
