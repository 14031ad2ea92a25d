// What the slow ways to filter under a mask share: one pixel an invocation.
#include "params.glsl"
#include "pixel.glsl"
#include "screen.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Weights { float weights[]; };  // by distance, 0 beyond the window
layout(std430, binding = 2) readonly buffer Pixels { uint pixels[]; };

int window() {
    return int(params.window);
}

// Coordinates of this invocation's pixel.
ivec2 own_pixel() {
    return ivec2(gl_GlobalInvocationID.xy);
}

uint pixel_at(ivec2 at) {
    return pixels[pixel_index(uvec2(at))];
}
