// Sums of velocities over a workgroup.
#include "directions.glsl"

shared vec4 velocity_sums[DIRECTIONS];

// Of pixels a frame: sum, sum of speeds, and number.
vec4 join_velocities(vec4 a, vec4 b) {
    return a + b;
}

// That of all invocations.
vec4 sum_velocities(vec4 own, uint lane) {
    velocity_sums[lane] = own;
    barrier();
    for (uint half_way = DIRECTIONS / 2u; half_way > 0u; half_way >>= 1u) {
        if (lane < half_way) {
            velocity_sums[lane] = join_velocities(velocity_sums[lane], velocity_sums[lane + half_way]);
        }
        barrier();
    }
    return velocity_sums[0];
}
