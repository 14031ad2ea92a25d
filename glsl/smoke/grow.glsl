// What the ways to search a radius share: from the raw radius to the sphere that is drawn.
#include "particle.glsl"
#include "../common/random.glsl"

layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) writeonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 6) buffer Radii { float radii[]; };  // before `scale` and growth
#include "voxels.glsl"

vec3 position_of(uint slot) {
    return to_vector(particles[slot].position);
}

bool is_alive(uint slot) {
    return particles[slot].age != DEAD;
}

const float MOST_OUTSIDE = 0.25;  // that a kept radius may leave the smoke by, in smallest sides of a voxel
const float AT_REST = 1e-3;       // a smoothed radius this near to its goal is there, in smallest sides of a voxel

// Whether `radii` has the particle's radius of the last frame.
bool had_radius(uint slot) {
    return params.frames > 0u && particles[slot].age > 0u;
}

// While a particle lives, its radius keeps a share of the last frame's.
float smoothed_radius(uint slot, float radius) {
    if (params.radius_smoothing == 0.0 || !had_radius(slot)) {
        return radius;
    }
    float kept = mix(radius, radii[slot], params.radius_smoothing);
    kept = abs(kept - radius) <= AT_REST * params.smallest_side ? radius : kept;
    return min(kept, radius + MOST_OUTSIDE * params.smallest_side);
}

const float BOIL_SIZE = 0.25;  // share of a radius that it differs by at most, where `boil` is 1

// What a radius is multiplied by in this drawing, as if each were drawn anew.
float boiled(uint slot) {
    float any_ = unit(hash(params.seed, slot, params.frames, BOIL_SIZE_OF));
    return 1.0 + params.boil * BOIL_SIZE * (2.0 * any_ - 1.0);
}

// Newborn spheres grow by smoothstep over `fade` frames.
void put_sphere(uint slot, vec3 p, float raw) {
    uint age = particles[slot].age;
    float radius = smoothed_radius(slot, raw);
    radii[slot] = radius;
    float t = min(float(age + 1u) / float(params.fade + 1u), 1.0);
    float grown = (age & FULL_SIZE) != 0u ? 1.0 : t * t * (3.0 - 2.0 * t);
    spheres[slot] = vec4(p, radius * params.scale * grown * boiled(slot));
}
