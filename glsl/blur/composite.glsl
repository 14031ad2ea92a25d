// Replaces what is not frame i + 1's own.
layout(std430, binding = 1) readonly buffer Picture { vec4 picture[]; };
layout(location = 0) out vec4 colour;

// The pixel's place in the picture.
uint replace() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint index = at.y * params.image.x + at.x;
    colour = picture[index];
    if (floatBitsToUint(colour.a) >> 31u != 0u) {
        discard;
    }
    return index;
}
