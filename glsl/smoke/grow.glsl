// What the ways to search a radius share: from the raw radius to the sphere that is drawn.
#include "particle.glsl"

layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) writeonly buffer Spheres { vec4 spheres[]; };
#include "voxels.glsl"

vec3 position_of(uint slot) {
    return to_vector(particles[slot].position);
}

bool is_alive(uint slot) {
    return particles[slot].age != DEAD;
}

// Newborn spheres grow by smoothstep over `fade` frames.
void put_sphere(uint slot, vec3 p, float radius) {
    uint age = particles[slot].age;
    float t = min(float(age + 1u) / float(params.fade + 1u), 1.0);
    float grown = (age & FULL_SIZE) != 0u ? 1.0 : t * t * (3.0 - 2.0 * t);
    spheres[slot] = vec4(p, radius * params.scale * grown);
}
