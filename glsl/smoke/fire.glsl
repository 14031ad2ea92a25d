// The fire as the smoke sees it: a point light with falloff, whose shadows are coarse. To be included with the occupancy bound.
#include "voxels.glsl"
#include "occupancy.glsl"

const uint WAY_SAMPLES = 16u;  // of the way to the fire

// Share of the way between two places that is free of smoke, from evenly spaced samples of the voxels. With an emitter, smoke
// outside of it is not drawn, or only in passing, and throws no shadow.
float free_share(vec3 from, vec3 to) {
    uint free = 0u;
    for (uint i = 0u; i < WAY_SAMPLES; ++i) {
        vec3 p = mix(from, to, (float(i) + 0.5) / float(WAY_SAMPLES));
        vec3 voxel = floor((p - params.origin.xyz) / params.voxel_size.xyz);
        bool is_drawn = params.has_emitter == 0u
            || all(greaterThanEqual(p, params.emitter_min.xyz)) && all(lessThanEqual(p, params.emitter_max.xyz));
        // Far away there are more voxels than integers.
        bool is_smoke = is_drawn && is_occupied(ivec3(clamp(voxel, vec3(-1.0), vec3(params.dimensions.xyz))));
        free += is_smoke ? 0u : 1u;
    }
    return float(free) / float(WAY_SAMPLES);
}

// Share of the fire's light that a surface has, 0 to 1: it wraps around, is halved at the fire's reach, and comes by what of the
// way is free.
float fire_light(vec3 p, vec3 normal) {
    vec3 way = params.fire.xyz - p;
    float squared = dot(way, way);
    float facing = squared > 0.0 ? dot(normal, way) * inversesqrt(squared) : 0.0;
    float wrapped = 0.5 + 0.5 * clamp(facing, -1.0, 1.0);
    return wrapped * free_share(p, params.fire.xyz) / (1.0 + squared * params.fire.w);
}
