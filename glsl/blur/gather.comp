// Positions that the host's own skinning has left on the device, as a pose of the mesh's points.
#version 460
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Source { float source_values[]; };
layout(std430, binding = 1) readonly buffer SourceRows { uint source_rows[]; };
layout(std430, binding = 2) writeonly buffer Poses { float poses[]; };
layout(push_constant) uniform GatherConstants {
    uint first;   // of the points that come from here
    uint count;
    uint offset;  // of the first vertex, in floats
    uint stride;  // floats from vertex to vertex
    uint pose;    // where the pose begins among those on the device, in floats
} constants;

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= constants.count) {
        return;
    }
    uint point = constants.first + row;
    uint from = constants.offset + constants.stride * source_rows[point];
    uint to = constants.pose + 3u * point;
    for (uint axis = 0u; axis < 3u; ++axis) {
        poses[to + axis] = source_values[from + axis];
    }
}
