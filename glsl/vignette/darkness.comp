// How dark each pixel becomes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 1) writeonly buffer Darkness { float darkness[]; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec2 from_centre = (2.0 * vec2(pixel) + 1.0) / vec2(size) - 1.0;
    float way = length(from_centre) / sqrt(2.0);
    darkness[pixel.y * size.x + pixel.x] = strength * smoothstep(radius, 1.0, way);
}
