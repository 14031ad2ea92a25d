// The mesh's triangles, as the refinement begins: those that can't be divided are finished at once. Which side of them is
// outside is noted.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 2) readonly buffer Clip { vec4 clip[]; };
layout(std430, binding = 3) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 4) writeonly buffer Active { uvec4 active_triangles[]; };
layout(std430, binding = 5) readonly buffer Fronts { uint fronts[]; };  // FRONTS_A_WORD triangles a word
#include "base.glsl"
#include "edges.glsl"

// Whether a triangle's outside is turned away in frame i (0) or i + 1 (1), as clip coordinates have it: clockwise on a screen
// whose y is down is towards, unless the frame has it inside out.
bool is_away(uvec3 corners, uint front, uint frame) {
    uint first = (1u + frame) * params.points;
    vec3 a = clip[first + corners.x].xyz;
    vec3 b = clip[first + corners.y].xyz;
    vec3 c = clip[first + corners.z].xyz;
    float volume = volume_of(a, b, c);
    return (front & TURNED << frame) != 0u ? volume < 0.0 : volume > 0.0;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= params.triangles) {
        return;
    }
    uvec4 triangle = triangles[index];
    uint front = fronts[index / FRONTS_A_WORD] >> (FRONT_BITS * (index % FRONTS_A_WORD)) & FRONT_MASK;
    triangles[index].w = triangle.w & ~FRONT_MASK | front;
    bool is_hidden = (front & CLOSED) != 0u && is_away(triangle.xyz, front, 0u) && is_away(triangle.xyz, front, 1u);
    uint state = is_hidden ? CULLED : is_still(triangle) ? 0u : 7u << OPEN_SHIFT;
    active_triangles[index] = uvec4(triangle.xyz, index | state);
}
