// Chessboard distance field, pass along y.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#define AXIS 1
#define FROM Field
#define TO FieldColumns
#include "field_axis.glsl"
