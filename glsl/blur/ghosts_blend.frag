// Blends an after-image in behind the mesh.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "behind.glsl"
layout(binding = 6) uniform texture2D ghost;
layout(binding = 7) uniform texture2D ghost_depth;
#include "ghosts.glsl"
#include "common/fragment.glsl"
layout(location = 0) out vec4 colour;

void main() {
    ivec2 pixel = ivec2(pixel_of(gl_FragCoord.xy, params.corner, params.size));
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 at = sample_of(pixel, i);
        if (is_behind(at, texelFetch(ghost_depth, at, 0).x)) {
            sum += 0.25 * texelFetch(ghost, at, 0);
        }
    }
    colour = constants.opacity * sum;
    if (colour.a == 0.0) {
        discard;
    }
}
