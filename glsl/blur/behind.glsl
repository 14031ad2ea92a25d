// Which samples of a pixel let something be seen that is behind the mesh: those that see nothing, or what is farther away
// and stays where it is.
layout(binding = 1) uniform utexture2D sampled;
layout(binding = 2) uniform texture2D sampled_depth;
layout(std430, binding = 3) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 4) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 5) readonly buffer Triangles { uvec4 triangles[]; };
#include "base.glsl"
#include "picture.glsl"

bool is_behind(ivec2 at, float nearness) {
    uint triangle_id = texelFetch(sampled, at, 0).x;
    if (triangle_id == 0u) {
        return true;
    }
    uvec4 base = triangles[finished[triangle_id - 1u].w & BASE_MASK];
    return is_still(base) && nearness > texelFetch(sampled_depth, at, 0).x;
}
