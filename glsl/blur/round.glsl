// Which round of the refinement it is.
layout(push_constant) uniform RoundConstants {
    uint round;
} constants;
