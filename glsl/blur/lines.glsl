// Speed lines.
layout(push_constant) uniform LinesConstants {
    vec4 colour;      // linear RGB, opacity where a line begins
    float length_of;  // frames
    float width;      // pixels where it begins
} constants;
