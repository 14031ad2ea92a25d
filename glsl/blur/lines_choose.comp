// The points that speed lines trail from: of each of a cluster's strips along its motion, the rearmost. It is found in three
// rounds: the least k, of those that have it the least l, of those the first.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 2) buffer Trailing { uvec4 trailing[]; };
layout(push_constant) uniform ChooseConstants {
    uint round;
    uint strips;  // of a cluster
} constants;

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.counts.x) {
        return;
    }
    Vertex vertex = vertices[point];
    uint label = vertex.place.x;
    if (label == 0u) {
        return;
    }
    uint strip = min(uint(vertex.extent.y * float(constants.strips)), constants.strips - 1u);
    uint at = (label - 1u) * constants.strips + strip;
    uint k = floatBitsToUint(vertex.extent.x);
    uint l = floatBitsToUint(vertex.extent.y);
    if (constants.round == 0u) {
        atomicMin(trailing[at].x, k);
    } else if (trailing[at].x == k) {
        if (constants.round == 1u) {
            atomicMin(trailing[at].y, l);
        } else if (trailing[at].y == l) {
            atomicMin(trailing[at].z, point);
        }
    }
}
