// World normals of frames i and i + 1, and i - 1 and i + 2 where these are drawn: sums over a group's triangles of the cross
// products of their sides, in whole numbers, so that their order does not matter. Groups of many triangles are left to
// workgroups.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
#include "faces.glsl"

void main() {
    uint group = gl_GlobalInvocationID.x;
    uint place = gl_GlobalInvocationID.y;
    if (group >= GROUPS || place > 3u) {
        return;
    }
    uint frame = frame_of_normals(place);
    uint begin = group_starts[group];
    uint end = group_starts[group + 1u];
    if (end - begin > FEW_TRIANGLES) {
        if (place == 0u) {
            large_groups[atomicAdd(large_arguments.x, 1u)] = group;
        }
        return;
    }
    ivec3 sum = ivec3(0);
    int bits;
    if (has_units(largest(frame, begin, end, 1u), end - begin, bits)) {
        for (uint i = begin; i < end; ++i) {
            sum += ivec3(roundEven(ldexp(face(frame, group_triangles[i]), ivec3(bits))));
        }
    }
    normals[place * GROUPS + group] = vec4(ldexp(vec3(sum), ivec3(-bits)), 0.0);
}
