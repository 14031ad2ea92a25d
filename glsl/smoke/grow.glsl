// What the ways to search a radius share: from the raw radius to the sphere that is drawn.
struct Particle {
    vec4 position_age;
    vec4 step_generation;
};

layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) writeonly buffer Spheres { vec4 spheres[]; };
#include "voxels.glsl"

bool is_alive(uint slot) {
    return floatBitsToUint(particles[slot].position_age.w) != 0xffffffffu;
}

// Newborn spheres grow by smoothstep over `fade` frames; those of the first frame have the top bit set.
void put_sphere(uint slot, vec3 p, float radius) {
    uint age = floatBitsToUint(particles[slot].position_age.w);
    float t = min(float(age + 1u) / float(params.counts.y + 1u), 1.0);
    float grown = (age & 0x80000000u) != 0u ? 1.0 : t * t * (3.0 - 2.0 * t);
    spheres[slot] = vec4(p, radius * params.shade.z * grown);
}
