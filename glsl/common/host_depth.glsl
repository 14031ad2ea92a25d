// The host's depth image.
layout(push_constant) uniform HostDepthConstants { vec2 terms; } constants;  // what it holds: x + y / view depth

float host_depth(float depth) {
    return clamp(constants.terms.x + constants.terms.y / depth, 0.0, 1.0);
}
