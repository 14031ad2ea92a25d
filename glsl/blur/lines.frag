// A speed line's pixel, where it is behind the mesh.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "behind.glsl"
#include "common/random.glsl"
#include "lines.glsl"
#include "common/fragment.glsl"
layout(location = 0) in float aside;
layout(location = 1) in float share;
layout(location = 2) in float broad;
layout(location = 0) out vec4 drawn;

void main() {
    ivec2 pixel = ivec2(pixel_of(gl_FragCoord.xy, params.corner, params.size));
    float covered = 0.0;
    for (int i = 0; i < 4; ++i) {
        covered += is_behind(sample_of(pixel, i), gl_FragCoord.z) ? 0.25 : 0.0;
    }
    // How much of the pixel is between the line's sides.
    float side = 0.5 * broad * (1.0 - share);
    float within = clamp(side - aside + 0.5, 0.0, 1.0) - clamp(-side - aside + 0.5, 0.0, 1.0);
    float opacity = constants.colour.a * (1.0 - share) * max(within, 0.0) * covered;
    drawn = vec4(constants.colour.rgb * opacity, opacity);
    if (opacity == 0.0) {
        discard;
    }
}
