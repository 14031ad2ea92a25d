// The points that speed lines trail from: of each of a cluster's strips along its motion, the rearmost. It is found in three
// rounds: the least k, of those that have it the least l, of those the first.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "common/random.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 2) buffer Trailing { Trail trailing[]; };
layout(std430, binding = 3) readonly buffer Clusters { Cluster clusters[]; };
layout(push_constant) uniform ChooseConstants {
    uint round;
    uint strips;  // of a cluster
    float variation;  // how far the borders of strips are moved at most, as a share of a strip
} constants;

const uint STRIP_SLOT = 229376u;  // where the random numbers of strips begin

// The strip of a place across a cluster: borders between strips are moved to both sides.
uint strip_of(float l, uint object) {
    float across = l * float(constants.strips);
    uint strip = min(uint(across), constants.strips - 1u);
    uint nearest = uint(across + 0.5);
    float off = unit(hash(params.seed, object, STRIP_SLOT + nearest, params.generation)) - 0.5;
    float border = float(nearest) + off * constants.variation;
    bool is_inner = nearest > 0u && nearest < constants.strips;
    return !is_inner ? strip : across < border ? nearest - 1u : nearest;
}

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
    uint strip = strip_of(vertex.l, label == BETWEEN ? 0u : clusters[label - 1u].object);
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
