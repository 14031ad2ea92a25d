// How the host's image holds depth.
#include "../common/host_depth.glsl"
layout(push_constant) uniform HostDepthConstants { vec2 terms; } constants;
