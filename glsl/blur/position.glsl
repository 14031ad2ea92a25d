// Where the rasteriser sees clip coordinates: depth is near / W, so that nearer is larger and nothing is too far.
vec4 position_of(vec3 clip) {
    precise vec2 at = 2.0 * clip.xy / vec2(params.size) - clip.z;
    return vec4(at, params.near, clip.z);
}
