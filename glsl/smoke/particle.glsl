// A slot of particles: one lives in it after the other.
struct Particle {
    float position[3];      // metres
    uint age;               // frames since birth, with FULL_SIZE; or DEAD
    float displacement[3];  // until the next frame, metres
    uint generation;        // births so far
};

const uint FULL_SIZE = 0x80000000u;  // of an age: born at full size
const uint DEAD = 0xffffffffu;       // instead of an age

// Dimensions of randomness.
const uint BIRTH_VOXEL = 0u;
const uint BIRTH_PLACE = 1u;  // in the voxel, along x; y and z follow
const uint FIRST_AGE = 4u;
const uint BOIL_SIZE_OF = 5u;

vec3 to_vector(float v[3]) {
    return vec3(v[0], v[1], v[2]);
}
