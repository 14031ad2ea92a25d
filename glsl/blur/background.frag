// What an output begins with where frames are drawn: frame i + 1 over the background.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
layout(binding = 1) uniform texture2D drawn;
layout(binding = 2) uniform texture2D background_image;
#include "under.glsl"
#include "common/fragment.glsl"
layout(location = 0) out vec4 colour;

void main() {
    ivec2 pixel = ivec2(pixel_of(gl_FragCoord.xy, constants.corner, uvec2(textureSize(drawn, 0))));
    colour = over_background(texelFetch(drawn, pixel, 0), pixel);
}
