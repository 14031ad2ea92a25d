// The refined triangles, each vertex where its own time puts it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 1) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 2) readonly buffer Vertices { Vertex vertices[]; };
layout(location = 0) flat out uint triangle_id;
#include "position.glsl"

void main() {
    uint index = uint(gl_VertexIndex) / 3u;
    triangle_id = index + 1u;
    uvec4 triangle = finished[index];
    bool is_hidden = (triangle.w & CULLED) != 0u;
    uint vertex = triangle[uint(gl_VertexIndex) % 3u];
    vec2 drawn = vertices[vertex].drawn;
    float depth = vertices[vertex].drawn_depth;
    // A triangle whose corners are all in one place, behind the near plane, is drawn nowhere.
    gl_Position = is_hidden ? vec4(0.0, 0.0, 1.0, -1.0) : position_at(drawn, depth);
}
