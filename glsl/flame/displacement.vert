// Two triangles a particle over all that its sprites can touch, with how far it has moved since the frame before.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/limits.glsl"
#include "cells.glsl"
#include "stretch.glsl"
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 3) readonly buffer Positions { vec4 positions[]; };
layout(std430, binding = 4) readonly buffer Previous { vec4 previous[]; };  // metres; w: unused
layout(std430, binding = 6) readonly buffer Stretches { uint stretches[]; };
layout(location = 0) flat out vec4 centre;  // in view space; w: 1 / squared radius of the ball that its sprites reach
layout(location = 1) flat out vec4 moved;   // along the world's axes; w: mean number of render particles
#include "depth_range.glsl"
#include "particle_quad.glsl"

void main() {
    uint row = particle_row();
    Particle particle = particles[row];
    vec3 view = from_eye(vec3(particle.view, particle.depth));
    vec2 half_side = half_sprite(view.z);
    vec2 w = stretch_of(stretches[row]);
    float radius = (params.bounding_radius + max(half_side.x, half_side.y)) * (1.0 + dot(w, w));
    centre = vec4(view, 1.0 / (radius * radius));
    vec3 way = positions[row].xyz - previous[row].xyz;
    bool is_known = is_finite(way.x) && is_finite(way.y) && is_finite(way.z) && all(lessThanEqual(abs(way), vec3(FARTHEST)));
    moved = vec4(is_known ? way : vec3(0.0), particle.mean_count);
    vec4 bounds = pixel_bounds(view, particle.reach, stretched_reach(w));
    vec2 at = mix(bounds.xy, bounds.zw, particle_corner());
    // Dropped particles have no extent.
    gl_Position = vec4(particle.count != 0u ? 2.0 * at / vec2(params.size) - 1.0 : vec2(0.0), 0.0, 1.0);
}
