// Blending by 6 power moments.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define MOMENTS 6u
#include "bench_moments.glsl"
