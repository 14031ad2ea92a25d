// An after-image.
layout(push_constant) uniform GhostConstants {
    vec4 ink;       // colour of the line around a copy, linear RGB; w: its strength, 0: there is none
    float back;     // frames before
    float opacity;
    float radius;   // of the line, in samples
} constants;
