// Luminance without shadows.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRST_PART true
#include "params.glsl"
#include "luminance.glsl"

float lit_share(Surface surface, float before) {
    return before;
}
