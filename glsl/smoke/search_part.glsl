// What a part of any search has: its push constants say `part` and `is_ball`.
layout(std430, binding = 5) buffer Continuations { uvec4 continuations[]; };  // dispatches that go on

const uint FINISHED = 0xffffffffu;  // instead of a cursor

// Distances are combined as they are measured: along each axis, then the largest, or the root of the sum of squares.
float combined(float a, float b, float c) {
    return constants.is_ball != 0u ? sqrt(a * a + b * b + c * c) : max(a, max(b, c));
}

float along(vec3 p, int index, int axis) {
    return abs(p[axis] - voxel_centre(index, axis));
}

// The nearest voxel outside of the volume lies straight across one of its faces.
float outside_distance(vec3 p, ivec3 voxel) {
    vec3 own = vec3(along(p, voxel.x, 0), along(p, voxel.y, 1), along(p, voxel.z, 2));
    vec3 out_ = vec3(min(along(p, -1, 0), along(p, int(params.dimensions.x), 0)),
                     min(along(p, -1, 1), along(p, int(params.dimensions.y), 1)),
                     min(along(p, -1, 2), along(p, int(params.dimensions.z), 2)));
    return min(combined(out_.x, own.y, own.z), min(combined(own.x, out_.y, own.z), combined(own.x, own.y, out_.z)));
}

void ask_for_another() {
    uvec3 groups = constants.part == 0u ? gl_NumWorkGroups : continuations[constants.part - 1u].xyz;
    atomicMax(continuations[constants.part].x, groups.x);
    atomicMax(continuations[constants.part].y, 1u);
    atomicMax(continuations[constants.part].z, 1u);
}
