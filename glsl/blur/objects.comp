// The objects of the mesh that a pixel's four samples show, as a layer: their numbers, from 1; 0 is none.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
layout(constant_id = 0) const uint REFINED = 0;  // 1: samples see refined triangles, 0: those of the mesh
#include "params.glsl"
#include "picture.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
layout(binding = 1) uniform utexture2D sampled;
layout(std430, binding = 2) readonly buffer Triangles { uvec4 triangles[]; };
layout(std430, binding = 3) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 4) writeonly buffer ObjectLayer { uvec4 object_layer[]; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(params.size)))) {
        return;
    }
    uvec4 objects = uvec4(0u);
    for (int i = 0; i < 4; ++i) {
        uint triangle_id = texelFetch(sampled, sample_of(pixel, i), 0).x;
        if (triangle_id != 0u) {
            uint base = REFINED == 1u ? finished[triangle_id - 1u].w & BASE_MASK : triangle_id - 1u;
            objects[i] = 1u + (triangles[base].w >> OBJECT_SHIFT);
        }
    }
    object_layer[index_of(pixel)] = objects;
}
