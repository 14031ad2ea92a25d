// What the host tells the kernels that draw frames without images. `src/blur/params.rs` has the same structure.
layout(binding = 29) uniform ToonParams {
    vec4 light;         // unit vector to the light, or where it is in metres; w: 1 if it is somewhere
    vec4 ink;           // linear RGB; w: strength
    vec4 lens;          // metres that a sample spans at a depth of 1 metre; ambient luminance; width of the ink in samples; unused
    uvec4 counts;       // tones, normal groups; unused
    vec4 tones[256];    // linear RGB that the base colour is multiplied by; w: luminance where it begins
} toon;
