// Luminance of a surface: ambient + (1 - ambient) of the light, of which `fill` is soft. The soft part comes half from a
// light that wraps around and half from the hemisphere above, so that what the light does not reach keeps its form.
// `facing`, `up`: cosines between the normal and the light, and the hemisphere's axis; `s`: share of the light that arrives.
float luminance_of(float facing, float s, float up, float ambient, float fill) {
    float direct = max(facing, 0.0) * s;
    float wrapped = 0.5 + 0.5 * (direct + min(facing, 0.0));
    float hemisphere = 0.5 + 0.5 * up;
    return ambient + (1.0 - ambient) * mix(direct, 0.5 * (wrapped + hemisphere), fill);
}

// With a second light over it, which casts no shadows: it takes its share of what is missing to 1. `facing`: cosine between the
// normal and that light.
float with_second(float luminance, float facing, float strength) {
    return luminance + (1.0 - luminance) * strength * max(facing, 0.0);
}

const float RIM_FROM = 0.06;  // how far surfaces are turned away where the rim begins,
const float RIM_TO = 0.16;    // and from where on it is full

// How far a surface turns away from the light and from the eye, 0 to 1, by the cosines between its normal and both.
float turned_away(float facing, float eye) {
    float grazing = 1.0 - clamp(eye, 0.0, 1.0);
    return grazing * grazing * grazing * (0.5 - 0.5 * facing);
}

// With a rim over a luminance, as if light came from behind, where a surface is turned away so far.
float with_rim(float luminance, float away, float rim) {
    return luminance + (1.0 - luminance) * rim * smoothstep(RIM_FROM, RIM_TO, away);
}
