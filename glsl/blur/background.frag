// What an output begins with where frames are drawn: frame i + 1 over the background.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
layout(binding = 1) uniform texture2D drawn;
layout(push_constant) uniform BackgroundConstants {
    vec4 background;
} constants;
layout(location = 0) out vec4 colour;

void main() {
    vec4 own = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0);
    colour = own + (1.0 - own.a) * constants.background;
}
