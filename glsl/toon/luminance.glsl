// Luminance of a surface: ambient + (1 - ambient) of the light, of which `fill` is soft. The soft part comes half from a
// light that wraps around and half from the hemisphere above, so that what the light does not reach keeps its form.
// `facing`, `up`: cosines between the normal and the light, and the hemisphere's axis; `s`: share of the light that arrives.
float luminance_of(float facing, float s, float up, float ambient, float fill) {
    float direct = max(facing, 0.0) * s;
    float wrapped = 0.5 + 0.5 * (direct + min(facing, 0.0));
    float hemisphere = 0.5 + 0.5 * up;
    return ambient + (1.0 - ambient) * mix(direct, 0.5 * (wrapped + hemisphere), fill);
}
