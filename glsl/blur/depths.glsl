// Depths, and how near they are as depth buffers hold it: linear in the picture over a plane, larger is nearer, 0 is nothing.
#ifndef BLUR_DEPTHS
#define BLUR_DEPTHS
#include "common/bits.glsl"
#include "common/widening.glsl"

const float SAME_DEPTH = 0.003;  // share of its depth by which a surface may be off and still be the same

float nearness_of(float depth) {
    return params.is_orthographic != 0u ? (params.far - depth) / (params.far - params.near) : params.near / depth;
}

// View depth; infinite where nothing is.
float depth_of(float nearness) {
    float depth = params.is_orthographic != 0u ? params.far - nearness * (params.far - params.near) : params.near / nearness;
    return nearness > 0.0 ? depth : INFINITY;
}

// Nearness of a triangle's plane. `edges`: of its corners at a place of the picture; `depths`: theirs.
float nearness_of_plane(vec3 edges, vec3 depths) {
    float sum = edges.x + edges.y + edges.z;
    float along = dot(edges, depths);
    return params.is_orthographic != 0u ? nearness_of(along / sum) : params.near * sum / along;
}

// Whether what is so near is before something else by more than a share of depth: at most `least` times as far away.
bool is_before(float near, float other, float least) {
    float by = (near - other) * (params.far - params.near);
    bool is_parallel = params.is_orthographic != 0u && other > 0.0;
    return is_parallel ? by > (1.0 - least) * params.depth_unit : near * least > other;
}

// Whether a depth is beyond another by more than a share of it, which that is at most.
bool is_farther(float depth, float other, float least) {
    return params.is_orthographic != 0u ? depth - other > (1.0 - least) * params.depth_unit : depth * least > other;
}

#endif
