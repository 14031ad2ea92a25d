// Smooth normals of a frame: sums of triangles' areas over their groups, in whole numbers, so that their order does not
// matter.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Poses { float poses[]; };
layout(std430, binding = 2) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 3) readonly buffer GroupStarts { uint group_starts[]; };
layout(std430, binding = 4) readonly buffer GroupTriangles { uint group_triangles[]; };
layout(std430, binding = 5) writeonly buffer Normals { vec4 normals[]; };  // unit vectors, or 0 where there is no area; w: unused
layout(push_constant) uniform NormalConstants {
    uint frame;   // 0 to 3: frames i - 1 to i + 2
    uint groups;  // groups of corners that share a normal
} constants;

vec3 pose(uint point) {
    uint at = 3u * (params.views[constants.frame].slot.x * params.counts.x + point);
    return vec3(poses[at], poses[at + 1u], poses[at + 2u]);
}

vec3 area_of(uint triangle) {
    uvec4 corners = triangles[triangle];
    vec3 a = pose(corners.x);
    precise vec3 p = pose(corners.y) - a;
    precise vec3 q = pose(corners.z) - a;
    precise vec3 area = p.yzx * q.zxy - p.zxy * q.yzx;
    return area;
}

void main() {
    uint group = gl_GlobalInvocationID.x;
    if (group >= constants.groups) {
        return;
    }
    uint begin = group_starts[group];
    uint end = group_starts[group + 1u];
    float most = 0.0;
    for (uint i = begin; i < end; ++i) {
        vec3 size = abs(area_of(group_triangles[i]));
        most = max(most, max(max(size.x, size.y), size.z));
    }
    vec3 normal = vec3(0.0);
    if (most > 0.0 && most < uintBitsToFloat(0x7f800000u)) {
        int exponent;
        frexp(most, exponent);
        // The sum of all has at most 30 bits.
        int scale = min(29 - findMSB(end - begin) - exponent, 126);
        ivec3 sum = ivec3(0);
        for (uint i = begin; i < end; ++i) {
            sum += ivec3(roundEven(ldexp(area_of(group_triangles[i]), ivec3(scale))));
        }
        normal = sum == ivec3(0) ? normal : normalize(vec3(sum) * exp2(-29.0));
    }
    normals[constants.frame * constants.groups + group] = vec4(normal, 0.0);
}
