// What the host tells the kernels that draw frames without images. `src/blur/params.rs` has the same structure. No uniform
// block: lavapipe keeps a variant of a shader for each draw whose loops and branches depend on one, and so takes memory
// with each frame.
struct ToonParams {
    vec4 light;         // unit vector to the light, or where it is in metres; w: 1 if it is somewhere
    vec4 ink;           // linear RGB; w: strength
    vec4 lens;          // metres that a sample spans at a depth of 1 metre; ambient luminance; width of the ink in samples; unused
    uvec4 counts;       // tones, normal groups; unused
    vec4 tones[256];    // linear RGB that the base colour is multiplied by; w: luminance where it begins
};
layout(std430, binding = 29) readonly buffer ToonBuffer {
    ToonParams toon;
    vec4 base_colours[]; // of triangles' corners; linear RGB
};
