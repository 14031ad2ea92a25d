// The picture where it is not frame i + 1's own.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "composite.glsl"

void main() {
    replace();
}
