// Fire that is much farther away than it is deep: its depths from where it begins, in which single precision still tells
// its particles apart, and their range.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "cells.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) buffer Particles { Particle particles[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };

// How many times its depth a fire is away, from where on depths are counted from it. Nearer, rounding is a thousandth of
// the narrowest bins.
const float FAR_OFF = 64.0;

shared uint low_end;
shared uint high_end;

void main() {
    uint lane = gl_LocalInvocationID.x;
    float low = from_ordered(control.range_low);
    float high = from_ordered(control.range_high);
    if (!(low > FAR_OFF * (high - low))) {
        return;
    }
    if (lane == 0u) {
        low_end = NOTHING;
        high_end = 0u;
    }
    barrier();
    uint row = gl_GlobalInvocationID.x;
    if (row == 0u) {
        control.base = floatBitsToUint(low);
    }
    if (row < params.particle_count && particles[row].count != 0u) {
        float depth = (particles[row].depth - low) + particles[row].weight;
        particles[row].depth = depth;
        atomicMin(low_end, ordered(max(nearest_of(depth), params.near - low)));
        atomicMax(high_end, ordered(min(depth + params.bounding_radius, params.far - low)));
    }
    barrier();
    if (lane == 0u) {
        atomicMin(control.depth_low, low_end);
        atomicMax(control.depth_high, high_end);
    }
}
