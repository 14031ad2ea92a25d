// Chessboard distance field, pass along z.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#define AXIS 2
#define FROM FieldColumns
#define TO Field
#include "field_axis.glsl"
