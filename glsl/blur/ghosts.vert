// The refined triangles where they were some time before they are drawn.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 1) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 2) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 3) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 4) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 5) readonly buffer Splines { Piece splines[]; };
#include "ghosts.glsl"
#include "triangle_word.glsl"
layout(location = 0) out vec3 previous;  // where it is in frame i
layout(location = 1) out vec3 next;      // and in frame i + 1
layout(location = 2) out float moved;    // k'
layout(location = 3) flat out uint surface;
#include "curve.glsl"
#include "position.glsl"
#include "base.glsl"

vec3 place_of(uint frame, uvec4 base, vec3 barycentrics) {
    uint first = frame * params.points;
    return barycentrics.x * clip[first + base.x].xyz + barycentrics.y * clip[first + base.y].xyz + barycentrics.z * clip[first + base.z].xyz;
}

void main() {
    uvec4 triangle = finished[uint(gl_VertexIndex) / 3u];
    uint index = triangle[uint(gl_VertexIndex) % 3u];
    uvec4 base = triangles[triangle.w & BASE_MASK];
    vec2 place = barycentrics_of(index, base);
    vec3 barycentrics = vec3(1.0 - place.x - place.y, place);
    previous = place_of(1u, base, barycentrics);
    next = place_of(2u, base, barycentrics);
    moved = vertices[index].drawn_time;
    surface = surface_of(base.w);
    // What stays where it is leaves no image.
    if (is_still(base) || (triangle.w & CULLED) != 0u) {
        gl_Position = vec4(0.0, 0.0, 1.0, -1.0);
        return;
    }
    State state = state_at(index, index, 0u, moved - constants.back);
    gl_Position = position_at(state.position, state.depth);
}
