// Which frame is drawn.
layout(push_constant) uniform VisibilityConstants {
    uint frame;  // 0 to 3: frames i - 1 to i + 2
} constants;
