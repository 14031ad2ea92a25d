// As `normals`, of groups of many triangles: a workgroup each, so that no invocation leaves the loop budget.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
#include "faces.glsl"

const int LANE_BITS = 8;  // of the number of lanes
const int LOW_BITS = 15;  // of an invocation's sum, that are summed up by themselves

shared uint most;
shared int sums[9];  // of the higher bits of whole units, of the lower ones, and of parts of them

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint group = large_groups[gl_WorkGroupID.x];
    uint frame = frame_of_normals(gl_WorkGroupID.y);
    uint begin = group_starts[group];
    uint end = group_starts[group + 1u];
    if (lane < 9u) {
        sums[lane] = 0;
    }
    if (lane == 0u) {
        most = 0u;
    }
    barrier();
    // Floats that are not negative are in the order of their bits.
    atomicMax(most, floatBitsToUint(largest(frame, begin + lane, end, gl_WorkGroupSize.x)));
    barrier();
    uint iterations = (end - begin + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    int bits;
    // A unit's parts are at most half a unit, and all of them are summed up.
    int part_bits = SUM_BITS - LANE_BITS - findMSB(iterations);
    if (has_units(uintBitsToFloat(most), iterations, bits)) {
        ivec3 whole = ivec3(0);
        ivec3 parts = ivec3(0);
        for (uint i = begin + lane; i < end; i += gl_WorkGroupSize.x) {
            vec3 units = ldexp(face(frame, group_triangles[i]), ivec3(bits));
            vec3 rounded = roundEven(units);
            whole += ivec3(rounded);
            parts += ivec3(roundEven(ldexp(units - rounded, ivec3(part_bits))));
        }
        for (uint i = 0u; i < 3u; ++i) {
            atomicAdd(sums[i], whole[i] >> LOW_BITS);
            atomicAdd(sums[3u + i], whole[i] & ((1 << LOW_BITS) - 1));
            atomicAdd(sums[6u + i], parts[i]);
        }
    }
    barrier();
    if (lane == 0u) {
        vec3 high = ldexp(vec3(sums[0], sums[1], sums[2]), ivec3(LOW_BITS));
        vec3 low = vec3(sums[3], sums[4], sums[5]);
        vec3 parts = ldexp(vec3(sums[6], sums[7], sums[8]), ivec3(-part_bits));
        precise vec3 sum = high + (low + parts);
        normals[gl_WorkGroupID.y * GROUPS + group] = vec4(ldexp(sum, ivec3(-bits)), 0.0);
    }
}
