// Per particle: number of render particles, colour, alpha, place in the picture; what all of them have in common
// (brightest colour, nearest, depth range of what can be seen). What is not a number, not above 0 K, cold or off the screen is dropped.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/random.glsl"
#include "../common/view.glsl"
#include "cells.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Positions { vec4 positions[]; };
layout(std430, binding = 2) readonly buffer Ids { uint ids[]; };
layout(std430, binding = 3) readonly buffer Colours { vec4 colours[]; };
layout(std430, binding = 4) writeonly buffer Particles { Particle particles[]; };
layout(std430, binding = 5) buffer ControlBuffer { Control control; };
layout(constant_id = 0) const uint FORM = 0;  // what the entries of the colour table are
const uint CHROMATICITY = 1u;
const uint RAMP = 2u;

shared uint common_values[6];

const uint MOST_COUNT = 32768u;
const float MOST_LIGHT = 1e15;  // of a particle: squares of sums of it are finite
const float FARTHEST = 1e12;    // coordinate of a particle in metres: squares of it are finite

// As `flame::colour::Table` says.
vec3 colour_of(float t) {
    float place = clamp(params.colour.x * (FORM == RAMP ? t : 1.0 / t) + params.colour.y, 0.0, params.colour.z);
    uint below = uint(min(place, params.colour.z - 1.0));
    vec3 colour = mix(colours[below].rgb, colours[below + 1u].rgb, place - float(below));
    if (FORM != RAMP) {
        colour = max(exp(colour) - params.shift.rgb, 0.0);
    }
    if (FORM == CHROMATICITY) {
        float largest = max(max(colour.r, max(colour.g, colour.b)), 1e-30);
        colour *= pow(min(t / params.model.w, 1.0), params.colour.w) / largest;
    }
    return t < 700.0 ? vec3(0.0) : min(colour, MOST_LIGHT);
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (lane < 6u) {
        common_values[lane] = lane == 1u || lane == 2u ? 0xffffffffu : 0u;
    }
    barrier();
    uint row = gl_GlobalInvocationID.x;
    if (row < params.counts.x) {
        vec4 position = positions[row];
        bool is_near = all(lessThanEqual(abs(position.xyz), vec3(FARTHEST)));
        bool valid = is_finite(position.x) && is_finite(position.y) && is_finite(position.z) && is_finite(position.w) && position.w > 0.0 && is_near;
        float t = valid ? min(position.w, params.space.w) : 1.0;
        vec4 view_and_rest = valid ? to_view_and_rest(position.xyz) : vec4(0.0);
        vec3 view = view_and_rest.xyz;
        float alpha = params.model.x * t / params.model.w;
        float mean_count = min(params.model.z * t / params.model.w, float(MOST_COUNT));
        uint id = (params.flags.w & 2u) != 0u ? ids[row] : row;
        uint count = uint(mean_count);
        count += fract(mean_count) > unit(hash(params.draw.x, id, 0xffffffffu, 0u)) ? 1u : 0u;
        vec3 colour = colour_of(t);
        bool can_pass = count > 0u && min(alpha * params.light.y, 1.0) >= params.model.y;
        vec4 bounds = pixel_bounds(view, 1.0);
        bool seen = valid && can_pass && on_screen(bounds);
        if (valid) {
            atomicMax(common_values[0], floatBitsToUint(max(colour.r, max(colour.g, colour.b))));
            if (view.z >= params.lens.z) {
                atomicMin(common_values[1], floatBitsToUint(view.z));
            }
        }
        if (seen) {
            atomicMin(common_values[2], ordered(max(nearest_of(view.z), params.lens.z)));
            atomicMax(common_values[3], ordered(min(view.z + params.space.z, params.lens.w)));
            atomicAdd(common_values[4], 1u);
        }
        bool kept = params.flags.x == 1u ? seen : valid && count > 0u && on_screen(bounds);
        count = kept ? count : 0u;
        atomicMax(common_values[5], count);
        bool near_camera = view.z <= 1.001 * (params.space.z + params.lens.z);
        vec2 slope = near_camera ? vec2(0.0) : view.xy / view.z;
        vec2 centre = params.focal.yz + params.focal.x * vec2(slope.x, -slope.y);
        vec2 whole = floor(centre);
        particles[row] = Particle(vec4(view, alpha), vec4(whole.x, centre.x - whole.x, whole.y, centre.y - whole.y),
            vec4(slope, near_camera ? 1.0 : 0.0, 1.0), vec4(colour, mean_count),
            uvec4(pcg(id + pcg(params.draw.x)), id, count, floatBitsToUint(view_and_rest.w)), uvec4(0u));
    }
    barrier();
    if (lane == 0u) {
        atomicMax(control.brightest, common_values[0]);
        atomicMin(control.nearest, common_values[1]);
        atomicMin(control.range_low, common_values[2]);
        atomicMax(control.range_high, common_values[3]);
        atomicAdd(control.visible, common_values[4]);
        atomicMax(control.most, common_values[5]);
    }
}
