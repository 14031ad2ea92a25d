// The points that speed lines trail from: of each of a cluster's strips along its motion, the rearmost. It is found in three
// rounds: the least k, of those that have it the least l, of those the first.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 2) buffer Trailing { Trail trailing[]; };
layout(push_constant) uniform ChooseConstants {
    uint round;
    uint strips;  // of a cluster
} constants;

void main() {
    uint point = gl_GlobalInvocationID.x;
    if (point >= params.points) {
        return;
    }
    Vertex vertex = vertices[point];
    uint label = vertex.cluster;
    if (label == 0u) {
        return;
    }
    uint strip = min(uint(vertex.l * float(constants.strips)), constants.strips - 1u);
    uint at = (label - 1u) * constants.strips + strip;
    uint k = floatBitsToUint(vertex.k);
    uint l = floatBitsToUint(vertex.l);
    if (constants.round == 0u) {
        atomicMin(trailing[at].k, k);
    } else if (trailing[at].k == k) {
        if (constants.round == 1u) {
            atomicMin(trailing[at].l, l);
        } else if (trailing[at].l == l) {
            atomicMin(trailing[at].point, point);
        }
    }
}
