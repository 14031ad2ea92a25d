// Writes the lists of the cells. The order within a bucket is not fixed and does not matter: the nearest wins, sums are
// integers.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 3) buffer Cells { uint cell_ends[]; };
layout(std430, binding = 4) writeonly buffer Entries { uint entries[]; };
layout(std430, binding = 5) readonly buffer Stretches { uint stretches[]; };
#include "cells.glsl"
#include "stretch.glsl"
#include "depth_range.glsl"

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= params.particle_count || particles[row].count == 0u || (particles[row].flags & LISTED) == 0u) {
        return;
    }
    vec3 view = vec3(particles[row].view, particles[row].depth);
    vec2 farther = stretched_reach(stretch_of(stretches[row]));
    uvec4 cells;
    uint level = cells_of(pixel_bounds(from_eye(view), particles[row].reach, farther), cells);
    vec2 scale = bucket_scale();
    uint bucket = bucket_of(nearest_of(view.z), scale.x, scale.y);
    for (uint y = cells.y; y <= cells.w; ++y) {
        for (uint x = cells.x; x <= cells.z; ++x) {
            entries[atomicAdd(cell_ends[cell_index(level, x, y) * params.bucket_count + bucket], 1u)] = row;
        }
    }
}
