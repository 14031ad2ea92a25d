// What sums of triangles' normals are made of.
#include "common/bits.glsl"
layout(std430, binding = 1) readonly buffer Poses { float poses[]; };
layout(std430, binding = 2) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 3) readonly buffer GroupStarts { uint group_starts[]; };
layout(std430, binding = 4) readonly buffer GroupTriangles { uint group_triangles[]; };
layout(std430, binding = 5) writeonly buffer Normals { vec4 normals[]; };
// Dispatch over the groups that a workgroup sums up, and these.
layout(std430, binding = 6) buffer LargeGroups { uvec4 large_arguments; uint large_groups[]; };
layout(constant_id = 0) const uint GROUPS = 0;

const uint FEW_TRIANGLES = 1024u;  // of a group, that one invocation sums up; of more, a workgroup does
const int SUM_BITS = 30;           // of the sum of what an invocation sums up

#include "normal_order.glsl"

#include "poses.glsl"

// The cross product of a triangle's sides.
vec3 face(uint frame, uint triangle) {
    uvec4 corners = triangles[triangle];
    uint place = params.pose_places[frame];
    vec3 a = pose(place, corners.x);
    precise vec3 p = pose(place, corners.y) - a;
    precise vec3 q = pose(place, corners.z) - a;
    precise vec3 normal = p.yzx * q.zxy - p.zxy * q.yzx;
    return normal;
}

// The largest component of the faces of every `stride`th entry.
float largest(uint frame, uint begin, uint end, uint stride) {
    float most = 0.0;
    for (uint i = begin; i < end; i += stride) {
        vec3 size = abs(face(frame, group_triangles[i]));
        most = max(most, max(max(size.x, size.y), size.z));
    }
    return most;
}

// Whether there is anything to sum up, and how many bits its units are below 1: so many that the sum of `count` faces, none
// of which has a component above `most`, does not overflow.
bool has_units(float most, uint count, out int bits) {
    bits = 0;
    if (!(most > 0.0 && most < INFINITY)) {
        return false;
    }
    int above;
    frexp(most, above);
    bits = SUM_BITS - 1 - findMSB(count) - above;
    return true;
}
