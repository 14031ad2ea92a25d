// Counts particles in the cells that they touch, by depth bucket, and writes their colours as shares of the frame's
// brightest, which is known now. For the expected image, weighs them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) buffer Particles { Particle particles[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 3) buffer Cells { uint cell_ends[]; };
layout(std430, binding = 5) readonly buffer Stretches { uint stretches[]; };
layout(binding = 4, r32f) uniform readonly image2D levels;
layout(constant_id = 0) const uint EXPECTED = 0;  // 1: the kernel table is asked for
#include "cells.glsl"
#include "stretch.glsl"
#include "depth_range.glsl"
#include "mask_level.glsl"
#include "weigh.glsl"

uint share_of(float component, float brightest) {
    return brightest > 0.0 ? min(uint(component / brightest * LIGHT_STEPS + 0.5), uint(LIGHT_STEPS)) : 0u;
}

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= params.particle_count || particles[row].count == 0u) {
        return;
    }
    if (EXPECTED == 1u) {
        weigh(row);
    }
    vec3 view = vec3(particles[row].view, particles[row].depth);
    vec4 colour = particles[row].colour;
    float brightest = uintBitsToFloat(control.brightest);
    uint light = share_of(colour.r, brightest) | share_of(colour.g, brightest) << 16u;
    float reach = reach_of(colour.a, mask_level());
    vec4 bounds = pixel_bounds(from_eye(view), reach, stretched_reach(stretch_of(stretches[row])));
    uvec4 cells;
    uint level = cells_of(bounds, cells);
    bool touches = on_screen(bounds);
    particles[row].reach = reach;
    particles[row].light = uvec2(light, share_of(colour.b, brightest));
    if (!touches) {
        return;
    }
    particles[row].flags |= LISTED;
    vec2 scale = bucket_scale();
    uint bucket = bucket_of(nearest_of(view.z), scale.x, scale.y);
    for (uint y = cells.y; y <= cells.w; ++y) {
        for (uint x = cells.x; x <= cells.z; ++x) {
            atomicAdd(cell_ends[cell_index(level, x, y) * params.bucket_count + bucket], 1u);
        }
    }
}
