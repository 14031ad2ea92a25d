// Embers over the target.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "ember.glsl"
layout(location = 0) out vec4 colour;

void main() {
    float share = ember_share();
    colour = vec4(share * ember.light, share);
}
