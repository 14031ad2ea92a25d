// Chessboard distance field, pass along z.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#define AXIS 2
#include "field_axis.glsl"
