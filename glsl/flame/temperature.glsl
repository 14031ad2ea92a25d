// The light of a temperature, in linear RGB, as `flame::colour::Table` says. The including kernel binds `colours` and says FORM:
// what the entries of the colour table are.
const float MOST_LIGHT = 1e15;  // of a particle: squares of sums of it are finite

vec3 colour_of(float t) {
    float place = clamp(params.table_scale * (FORM == RAMP ? t : 1.0 / t) + params.table_offset, 0.0, params.table_last);
    uint below = uint(min(place, params.table_last - 1.0));
    vec3 colour = mix(colours[below].rgb, colours[below + 1u].rgb, place - float(below));
    if (FORM != RAMP) {
        colour = max(exp(colour) - params.table_shift.rgb, 0.0);
    }
    if (FORM == CHROMATICITY) {
        float largest = max(max(colour.r, max(colour.g, colour.b)), 1e-30);
        colour *= pow(min(t / params.hottest, 1.0), params.falloff) / largest;
    }
    return t < COLDEST ? vec3(0.0) : min(colour, MOST_LIGHT);
}
