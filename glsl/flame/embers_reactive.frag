// The share of each pixel that embers cover.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "ember.glsl"
layout(location = 0) out float share;

void main() {
    share = ember_share();
}
