// Per particle: number of render particles, colour, alpha, place in the picture; what all of them have in common
// (brightest colour, nearest, depth range of what can be seen). What is not a number, not above 0 K, cold or off the screen is dropped.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/limits.glsl"
#include "../common/random.glsl"
#include "../common/view.glsl"
#include "cells.glsl"
#include "stretch.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Positions { vec4 positions[]; };
layout(std430, binding = 2) readonly buffer Ids { uint ids[]; };
layout(std430, binding = 3) readonly buffer Colours { vec4 colours[]; };
layout(std430, binding = 4) writeonly buffer Particles { Particle particles[]; };
layout(std430, binding = 5) buffer ControlBuffer { Control control; };
layout(std430, binding = 6) readonly buffer Velocities { vec4 velocities[]; };  // m/s; w: unused
layout(std430, binding = 7) writeonly buffer Stretches { uint stretches[]; };
layout(constant_id = 0) const uint FORM = 0;  // what the entries of the colour table are
#include "temperature.glsl"

// Of the workgroup's particles, as `Control` has them of all.
shared uint brightest;
shared uint nearest;
shared uint range_low;
shared uint range_high;
shared uint visible;
shared uint most;

const float MOST_STRETCH = 7.0;  // sides of a sprite that it becomes longer

// How a particle's sprites are drawn out: by its way on screen, where that is known.
uint stretch_along(uint row, vec3 view, vec2 slope) {
    vec3 velocity = velocities[row].xyz;
    bool is_known = is_finite(velocity.x) && is_finite(velocity.y) && is_finite(velocity.z) && all(lessThanEqual(abs(velocity), vec3(FARTHEST)));
    velocity = is_known ? velocity : vec3(0.0);
    vec3 in_view = vec3(dot(params.camera.right.xyz, velocity), dot(params.camera.up.xyz, velocity), dot(params.camera.forward.xyz, velocity));
    vec2 way = params.stretch * (in_view.xy - slope * in_view.z);
    float along = length(way);
    float longer = min(along / (2.0 * half_sprite(view.z).x), MOST_STRETCH);
    return along > 0.0 ? packHalf2x16(way * (sqrt(longer) / along)) : 0u;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (lane == 0u) {
        brightest = 0u;
        nearest = NOTHING;
        range_low = NOTHING;
        range_high = 0u;
        visible = 0u;
        most = 0u;
    }
    barrier();
    uint row = gl_GlobalInvocationID.x;
    if (row < params.particle_count) {
        vec4 position = positions[row];
        bool is_near = all(lessThanEqual(abs(position.xyz), vec3(FARTHEST)));
        bool valid = is_finite(position.x) && is_finite(position.y) && is_finite(position.z) && is_finite(position.w) && position.w > 0.0 && is_near;
        float t = valid ? min(position.w, params.max_temperature) : 1.0;
        vec4 view_and_rest = valid ? to_view_and_rest(position.xyz) : vec4(0.0);
        vec3 view = view_and_rest.xyz;
        float alpha = params.alpha_scale * t / params.hottest;
        float mean_count = min(params.count * t / params.hottest, MOST_COUNT);
        uint id = params.has_ids != 0u ? ids[row] : row;
        uint count = uint(mean_count);
        count += fract(mean_count) > unit(hash(params.seed, id, COUNT_KEY, 0u)) ? 1u : 0u;
        vec3 colour = colour_of(t);
        bool can_pass = count > 0u && min(alpha * params.max_alpha, 1.0) >= params.threshold;
        bool is_parallel = params.is_orthographic != 0u;
        bool near_camera = !is_parallel && view.z <= 1.001 * (params.bounding_radius + params.near);
        vec2 seen_at = near_camera ? vec2(0.0) : view.xy / widening(view.z);
        vec2 slope = is_parallel ? vec2(0.0) : seen_at;
        uint stretch = 0u;
        if (params.stretch > 0.0 && params.has_velocities != 0u && !near_camera) {
            stretch = stretch_along(row, view, slope);
        }
        stretches[row] = stretch;
        vec4 bounds = pixel_bounds(view, 1.0, stretched_reach(stretch_of(stretch)));
        bool seen = valid && can_pass && on_screen(bounds);
        if (valid) {
            atomicMax(brightest, floatBitsToUint(max(colour.r, max(colour.g, colour.b))));
            if (view.z >= params.near) {
                atomicMin(nearest, floatBitsToUint(view.z));
            }
        }
        if (seen) {
            atomicMin(range_low, ordered(max(nearest_of(view.z), params.near)));
            atomicMax(range_high, ordered(min(view.z + params.bounding_radius, params.far)));
            atomicAdd(visible, 1u);
        }
        bool kept = params.is_skipping != 0u ? seen : valid && count > 0u && on_screen(bounds);
        count = kept ? count : 0u;
        atomicMax(most, count);
        vec2 centre = params.principal_point + params.focal_length * vec2(seen_at.x, -seen_at.y);
        vec2 whole = floor(centre);
        particles[row] = Particle(view.xy, view.z, mean_count, whole, centre - whole, slope, 1.0, near_camera ? NEAR_CAMERA : 0u,
            vec4(colour, alpha), pcg(id + pcg(params.seed)), id, count, 0u, uvec2(0u), view_and_rest.w, 0.0);
    }
    barrier();
    if (lane == 0u) {
        atomicMax(control.brightest, brightest);
        atomicMin(control.nearest, nearest);
        atomicMin(control.range_low, range_low);
        atomicMax(control.range_high, range_high);
        atomicAdd(control.visible, visible);
        atomicMax(control.most, most);
    }
}
