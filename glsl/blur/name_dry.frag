// As name.frag, where a bristle has left something.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "common/random.glsl"
layout(std430, binding = 3) readonly buffer Clusters { Cluster clusters[]; };
layout(constant_id = 0) const float DRY = 1.0;  // the setting
layout(location = 0) flat in uint triangle_id;
layout(location = 1) flat in uint own;
layout(location = 2) noperspective in vec3 extent;
layout(location = 0) out uint seen;

#include "dry.glsl"

void main() {
    if (own > 0u) {
        Cluster cluster = clusters[own - 1u];
        uint bristle = uint(max(extent.y, 0.0) * BRISTLES * float(cluster.teeth));
        float length_of = unit(hash(params.seed, cluster.object, BRISTLE_SLOT + bristle, params.generation));
        if (extent.x < longest_dry(DRY, extent.z) * length_of) {
            discard;
        }
    }
    seen = triangle_id;
}
