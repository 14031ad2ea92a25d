#include "toon/tones.glsl"

// What the host tells the kernels that draw frames without images. No uniform block: lavapipe keeps a variant of a shader
// for each draw whose loops and branches depend on one, and so takes memory with each frame.
struct ToonParams {
    vec4 light;          // homogeneous: unit vector to it (w = 0), or where it is in metres (w = 1)
    vec4 second_light;   // as `light`
    vec4 eye;            // as `light`, of the eye
    vec4 fill;           // unit axis of the hemisphere that fills; w: its share of the light
    vec4 ink_colour;     // linear RGB; w: unused
    float ink_strength;
    float ink_width;     // samples
    float sample_extent; // metres that a sample spans at a depth of 1 metre; orthographic: at any depth
    float ambient;       // luminance without the light
    uint tone_count;
    uint groups;         // normal groups
    float second_strength; // of the second light
    float rim;           // brightness of edges that turn away
    vec4 tones[MOST_TONES]; // linear RGB that the base colour is multiplied by; w: luminance where it begins
};
layout(std430, binding = 29) readonly buffer ToonBuffer {
    ToonParams toon;
    vec4 base_colours[]; // of triangles' corners; linear RGB; then textures, if there are any
};
