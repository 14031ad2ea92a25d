// Speed lines.
layout(push_constant) uniform LinesConstants {
    vec4 colour;      // linear RGB, opacity where a line begins
    float length_of;  // frames
    float width;      // pixels where it begins
    float variation;  // how much shorter and thinner the least of them is, as a share
} constants;

const uint LINE_SLOT = 196608u;  // where the random numbers of lines begin

// How long and how broad the line of a point is, of constants.length_of and width.
vec2 shape_of(uint point) {
    uint slot = LINE_SLOT + point;
    vec2 random = vec2(unit(hash(params.seed, 0u, slot, params.generation)), unit(hash(params.seed, 1u, slot, params.generation)));
    return 1.0 - constants.variation * random;
}
