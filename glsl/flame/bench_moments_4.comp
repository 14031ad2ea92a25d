// Blending by 4 power moments.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define MOMENTS 4u
#include "bench_moments.glsl"
