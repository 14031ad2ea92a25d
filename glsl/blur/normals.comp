// World normals of frames i and i + 1: sums over a group's triangles of the cross products of their sides, in whole
// numbers, so that their order does not matter.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Poses { float poses[]; };
layout(std430, binding = 2) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 3) readonly buffer GroupStarts { uint group_starts[]; };
layout(std430, binding = 4) readonly buffer GroupTriangles { uint group_triangles[]; };
layout(std430, binding = 5) writeonly buffer Normals { vec4 normals[]; };
layout(constant_id = 0) const uint GROUPS = 0;

const uint MOST_TRIANGLES = 20000u;  // of a group, that are looked at

vec3 position(uint frame, uint point) {
    uint at = 3u * (params.views[frame].slot.x * params.counts.x + point);
    return vec3(poses[at], poses[at + 1u], poses[at + 2u]);
}

vec3 face(uint frame, uint triangle) {
    uvec4 corners = triangles[triangle];
    vec3 a = position(frame, corners.x);
    precise vec3 p = position(frame, corners.y) - a;
    precise vec3 q = position(frame, corners.z) - a;
    precise vec3 normal = p.yzx * q.zxy - p.zxy * q.yzx;
    return normal;
}

void main() {
    uint group = gl_GlobalInvocationID.x;
    uint frame = 1u + gl_GlobalInvocationID.y;
    if (group >= GROUPS || frame > 2u) {
        return;
    }
    uint begin = group_starts[group];
    uint end = min(group_starts[group + 1u], begin + MOST_TRIANGLES);
    float most = 0.0;
    for (uint i = begin; i < end; ++i) {
        vec3 size = abs(face(frame, group_triangles[i]));
        most = max(most, max(max(size.x, size.y), size.z));
    }
    ivec3 sum = ivec3(0);
    int exponent = 0;
    if (most > 0.0 && most < uintBitsToFloat(0x7f800000u)) {
        int above;
        frexp(most, above);
        // The sum of all has 30 bits.
        exponent = above - 29 + findMSB(end - begin);
        for (uint i = begin; i < end; ++i) {
            sum += ivec3(roundEven(ldexp(face(frame, group_triangles[i]), ivec3(-exponent))));
        }
    }
    normals[(frame - 1u) * GROUPS + group] = vec4(ldexp(vec3(sum), ivec3(exponent)), 0.0);
}
