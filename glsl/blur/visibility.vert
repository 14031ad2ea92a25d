// A frame's triangles as they are.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 1) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 2) readonly buffer Clip { vec4 clip[]; };
#include "frame.glsl"
layout(location = 0) flat out uint triangle_id;
#include "position.glsl"

void main() {
    uint index = uint(gl_VertexIndex) / 3u;
    triangle_id = index + 1u;
    gl_Position = position_of(clip[constants.frame * params.points + triangles[index][uint(gl_VertexIndex) % 3u]].xyz);
}
