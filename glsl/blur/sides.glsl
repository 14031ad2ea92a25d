// Colours of both sides of a sample, in half precision: so those of a picture are no more than its samples' colours.

#include "common/half.glsl"

uvec2 packed(vec4 colour) {
    colour = clamp(colour, vec4(-MOST_HALF), vec4(MOST_HALF));
    return uvec2(packHalf2x16(colour.xy), packHalf2x16(colour.zw));
}

vec4 unpacked(uvec2 words) {
    return vec4(unpackHalf2x16(words.x), unpackHalf2x16(words.y));
}
