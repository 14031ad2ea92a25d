// As distort.vert, for smears that end in bristles: a fragment knows where it is in its cluster.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 1) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 2) readonly buffer Vertices { Vertex vertices[]; };
layout(location = 0) flat out uint triangle_id;
layout(location = 1) flat out uint cluster;  // 0: it does not end in bristles
layout(location = 2) noperspective out vec3 extent;  // k, l, and how far it is drawn back in pixels
#include "position.glsl"
#include "dry.glsl"

void main() {
    uint index = uint(gl_VertexIndex) / 3u;
    triangle_id = index + 1u;
    uvec4 triangle = finished[index];
    bool is_hidden = (triangle.w & CULLED) != 0u;
    Vertex vertex = vertices[triangle[uint(gl_VertexIndex) % 3u]];
    // Between clusters k and l are of neither.
    uint first = vertices[triangle.x].cluster;
    bool is_one = first != BETWEEN && vertices[triangle.y].cluster == first && vertices[triangle.z].cluster == first;
    cluster = is_one ? first : 0u;
    extent = vec3(ends_of(vertex), vertex.l).xzy;
    gl_Position = is_hidden ? vec4(0.0, 0.0, 1.0, -1.0) : position_at(vertex.drawn, vertex.drawn_depth);
}
