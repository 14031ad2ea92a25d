// Counts the live spheres in each light-space tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = LIVE_LANES) in;
layout(std430, binding = 1) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 2) readonly buffer Live { uint live_list[]; };
layout(std430, binding = 3) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 4) buffer Cells { uint cell_ends[]; };
#include "light.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= control.live) {
        return;
    }
    vec4 sphere = spheres[live_list[gl_GlobalInvocationID.x]];
    uint bucket = bucket_of_sphere(sphere);
    for (uint face = 0u; face < params.light_faces; ++face) {
        uint level;
        uvec4 cells;
        if (cells_of(sphere, face, level, cells)) {
            for (uint y = cells.y; y <= cells.w; ++y) {
                for (uint x = cells.x; x <= cells.z; ++x) {
                    uint cell = first_cell(face, level) + y * (1u << level) + x;
                    atomicAdd(cell_ends[cell * BUCKETS + bucket], 1u);
                }
            }
        }
    }
}
