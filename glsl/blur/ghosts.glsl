// An after-image.
layout(push_constant) uniform GhostConstants {
    float back;     // frames before
    float opacity;
} constants;
