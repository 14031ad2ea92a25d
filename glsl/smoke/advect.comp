// Moves the particles by one frame; deaths and births are tested in this frame's volume (paper, section 3.1). What dies
// moves on and shrinks in a ring of its own. Everything is a function of (seed, slot, generation).
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const bool MIDPOINT = false;  // the midpoint rule instead of Euler's
layout(constant_id = 1) const bool KEEP_MOTION = false;  // how far spheres move is asked for
#include "params.glsl"
#include "../common/bits.glsl"
#include "../common/random.glsl"
layout(local_size_x = 64) in;
#include "particle.glsl"

layout(std430, binding = 1) readonly buffer Velocity { float velocity[]; };
layout(std430, binding = 2) readonly buffer Occupancy { uint occupancy[]; };
layout(std430, binding = 3) readonly buffer BirthCounts { uint birth_counts[]; };
layout(std430, binding = 5) buffer Particles { Particle particles[]; };
layout(std430, binding = 6) buffer Dying { vec4 dying[]; };           // position, radius at death
layout(std430, binding = 7) buffer DyingSteps { vec4 dying_steps[]; };
layout(std430, binding = 8) buffer Spheres { vec4 spheres[]; };       // position, displayed radius
layout(std430, binding = 9) buffer Groups { uint groups[]; };
layout(std430, binding = 10) writeonly buffer Moved { vec4 moved[]; };
#include "voxels.glsl"
#include "occupancy.glsl"

vec3 velocity_of(ivec3 v) {
    uint at = 3u * (row_of(uint(v.y), uint(v.z)) * params.dimensions.x + uint(v.x));
    vec3 value = vec3(velocity[at], velocity[at + 1u], velocity[at + 2u]);
    return vec3(is_finite(value.x) ? value.x : 0.0, is_finite(value.y) ? value.y : 0.0,
                is_finite(value.z) ? value.z : 0.0);
}

// Trilinear between voxel centres, constant outside of the outermost ones.
vec3 velocity_at(vec3 p) {
    vec3 last = vec3(params.dimensions.xyz) - 1.0;
    vec3 at = clamp((p - params.origin.xyz) / params.voxel_size.xyz - 0.5, vec3(0.0), last);
    ivec3 low = ivec3(at);
    ivec3 high = min(low + 1, ivec3(last));
    vec3 f = at - vec3(low);
    vec3 z0 = mix(mix(velocity_of(low), velocity_of(ivec3(high.x, low.yz)), f.x),
                  mix(velocity_of(ivec3(low.x, high.y, low.z)), velocity_of(ivec3(high.xy, low.z)), f.x), f.y);
    vec3 z1 = mix(mix(velocity_of(ivec3(low.xy, high.z)), velocity_of(ivec3(high.x, low.y, high.z)), f.x),
                  mix(velocity_of(ivec3(low.x, high.yz)), velocity_of(high), f.x), f.y);
    return mix(z0, z1, f.z);
}

vec3 step_from(vec3 p) {
    if (params.has_velocity == 0u) {
        return vec3(0.0);
    }
    float dt = params.dt;
    vec3 v = velocity_at(p);
    return dt * (MIDPOINT ? velocity_at(p + v * (0.5 * dt)) : v);
}

// Blocks of words whose births are counted; after the last stands how many voxels a birth may choose.
uint birth_blocks() {
    return (params.row_words * params.dimensions.y * params.dimensions.z + BIRTH_BLOCK - 1u) / BIRTH_BLOCK;
}

// The k-th voxel that a birth may choose.
ivec3 birth_voxel(uint k) {
    uint words = params.row_words * params.dimensions.y * params.dimensions.z;
    uint low = 0u;
    uint high = birth_blocks();
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (birth_counts[middle] <= k) { low = middle; } else { high = middle; }
    }
    uint rest = k - birth_counts[low];
    for (uint word = low * BIRTH_BLOCK; word < min(words, (low + 1u) * BIRTH_BLOCK); ++word) {
        uint row = word / params.row_words;
        ivec3 start = ivec3(word % params.row_words * WORD_VOXELS, row % params.dimensions.y, row / params.dimensions.y);
        uint bits = occupancy[word];
        if (any(lessThan(start.yz, params.emitter_first.yz)) || any(greaterThan(start.yz, params.emitter_last.yz))) {
            continue;
        }
        bits &= voxel_bits(start.x, params.emitter_first.x, params.emitter_last.x);
        uint count = uint(bitCount(bits));
        if (rest >= count) {
            rest -= count;
            continue;
        }
        for (; rest > 0u; --rest) {
            bits &= bits - 1u;
        }
        return start + ivec3(findLSB(bits), 0, 0);
    }
    return ivec3(-1);
}

vec3 birth_position(uint slot, uint generation) {
    uint seed = params.seed;
    ivec3 v = birth_voxel(below(hash(seed, slot, generation, BIRTH_VOXEL), birth_counts[birth_blocks()]));
    precise vec3 p;
    for (int a = 0; a < 3; ++a) {
        precise float low = params.origin[a] + float(v[a]) * params.voxel_size[a];
        precise float high = params.origin[a] + float(v[a] + 1) * params.voxel_size[a];
        if (params.has_emitter != 0u) {
            low = max(low, params.emitter_min[a]);
            high = min(high, params.emitter_max[a]);
        }
        p[a] = low + unit(hash(seed, slot, generation, BIRTH_PLACE + uint(a))) * (high - low);
    }
    return p;
}

void keep_motion(uint sphere, vec3 way) {
    if (KEEP_MOTION) {
        moved[sphere] = vec4(way, 0.0);
    }
}

float falling(uint age) {
    float t = min(float(age + 1u) / float(params.fade + 1u), 1.0);
    return 1.0 - t * t * (3.0 - 2.0 * t);
}

void move_dying(uint slot) {
    uint count = params.particles;
    uint fade = params.fade;
    for (uint row = 0u; row < fade; ++row) {
        uint at = row * count + slot;
        vec4 body = dying[at];
        if (row == params.ring_row || body.w <= 0.0) {
            continue;
        }
        vec3 way = dying_steps[at].xyz;
        vec3 p = body.xyz + way;
        keep_motion(count + at, way);
        uint age = (params.ring_row + fade - row) % fade;
        dying[at] = vec4(p, body.w);
        dying_steps[at] = vec4(step_from(p), 0.0);
        spheres[count + at] = vec4(p, body.w * falling(age));
    }
}

// At `p`, where it has gone `way`.
void begin_dying(uint slot, vec3 p, vec3 way, float radius) {
    if (params.fade == 0u) {
        return;
    }
    uint at = params.ring_row * params.particles + slot;
    uint sphere = params.particles + at;
    dying[at] = vec4(p, radius);
    dying_steps[at] = vec4(radius > 0.0 ? step_from(p) : vec3(0.0), 0.0);
    spheres[sphere] = vec4(p, radius * falling(0u));
    groups[sphere] = radius > 0.0 ? groups[slot] : 0u;
    keep_motion(sphere, way);
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= params.particles) {
        return;
    }
    bool restart = params.frames == 0u;
    Particle particle = particles[slot];
    uint age_bits = restart ? DEAD : particle.age;
    uint generation = restart ? 0u : particle.generation;
    vec3 p = to_vector(particle.position);
    if (!restart) {
        move_dying(slot);
    }
    vec3 way = vec3(0.0);
    float dying_radius = 0.0;
    if (age_bits != DEAD) {
        way = to_vector(particle.displacement);
        p += way;
        uint age = (age_bits & ~FULL_SIZE) + 1u;
        bool dies = !is_occupied(voxel_of(p)) || (params.lifetime > 0u && age >= params.lifetime)
            || (params.has_velocity != 0u && length(velocity_at(p)) <= params.still_speed);
        if (dies) {
            dying_radius = spheres[slot].w;
            age_bits = DEAD;
        } else {
            age_bits = age | (age_bits & FULL_SIZE);
        }
    }
    if (!restart) {
        begin_dying(slot, p, way, dying_radius);
    }
    if (age_bits == DEAD) {
        groups[slot] = 0u;
        way = vec3(0.0);
        if (birth_counts[birth_blocks()] > 0u) {
            p = birth_position(slot, generation);
            generation += 1u;
            // With a lifetime, particles of the first frame have lived for a while: they don't all end together.
            age_bits = restart ? FULL_SIZE | below(hash(params.seed, slot, 0u, FIRST_AGE), params.lifetime) : 0u;
        }
    }
    keep_motion(slot, way);
    bool alive = age_bits != DEAD;
    vec3 d = alive ? step_from(p) : vec3(0.0);
    particles[slot] = Particle(float[](p.x, p.y, p.z), age_bits, float[](d.x, d.y, d.z), generation);
}
