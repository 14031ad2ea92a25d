// Writes the lists of the light-space tiles. Their order is not fixed and does not matter: a shadow is a minimum.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = LIVE_LANES) in;
layout(std430, binding = 1) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 2) readonly buffer Live { uint live_list[]; };
layout(std430, binding = 3) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 4) buffer Cells { uint cell_ends[]; };
layout(std430, binding = 5) writeonly buffer Casters { uint casters[]; };
#include "light.glsl"

void main() {
    if (gl_GlobalInvocationID.x >= control.live) {
        return;
    }
    uint slot = live_list[gl_GlobalInvocationID.x];
    vec4 sphere = spheres[slot];
    uint bucket = bucket_of_sphere(sphere);
    for (uint face = 0u; face < params.light_faces; ++face) {
        uint level;
        uvec4 cells;
        if (cells_of(sphere, face, level, cells)) {
            for (uint y = cells.y; y <= cells.w; ++y) {
                for (uint x = cells.x; x <= cells.z; ++x) {
                    uint cell = first_cell(face, level) + y * (1u << level) + x;
                    casters[atomicAdd(cell_ends[cell * BUCKETS + bucket], 1u)] = slot;
                }
            }
        }
    }
}
