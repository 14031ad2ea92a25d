// The mesh's triangles, as the refinement begins: those that can't be divided are finished at once.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Triangles { uvec4 triangles[]; };  // corners; object * 2 + 1 if it is closed
layout(std430, binding = 2) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 3) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 4) writeonly buffer Active { uvec4 active_triangles[]; };

// Whether a triangle is turned away, as clip coordinates of a frame have it: clockwise on a screen whose y is down is towards.
bool is_away(uvec3 corners, uint frame) {
    uint first = frame * params.counts.x;
    vec3 a = clip[first + corners.x].xyz;
    vec3 b = clip[first + corners.y].xyz;
    vec3 c = clip[first + corners.z].xyz;
    return dot(a, cross(b, c)) > 0.0;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= params.counts.y) {
        return;
    }
    uvec4 triangle = triangles[index];
    bool is_moved = vertices[triangle.x].place.x + vertices[triangle.y].place.x + vertices[triangle.z].place.x > 0u;
    bool is_hidden = (triangle.w & 1u) != 0u && is_away(triangle.xyz, 1u) && is_away(triangle.xyz, 2u);
    uint state = is_hidden ? CULLED : is_moved ? 7u << OPEN_SHIFT : 0u;
    active_triangles[index] = uvec4(triangle.xyz, index | state);
}
