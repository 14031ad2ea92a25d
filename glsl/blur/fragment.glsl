// What a sample sees of the distorted mesh.

layout(std430, binding = 16) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 17) readonly buffer Vertices { Vertex vertices[]; };
#include "base.glsl"

struct Fragment {
    uvec4 base;    // the mesh's triangle
    uint place;    // its number
    vec3 barycentrics;  // in it
    float moved;   // k'
    uvec3 corners; // of the refined triangle
    vec3 inside;   // barycentrics in that
};

// Of a refined triangle at a place of the picture.
Fragment fragment_at(uint triangle_id, vec2 at) {
    uvec4 triangle = finished[triangle_id - 1u];
    uint place = triangle.w & BASE_MASK;
    uvec4 base = triangles[place];
    Vertex corners[3];
    vec2 places[3];
    for (uint corner = 0u; corner < 3u; ++corner) {
        corners[corner] = vertices[triangle[corner]];
        places[corner] = barycentrics_of(triangle[corner], base);
    }
    vec2 p = corners[0].drawn - at;
    vec2 q = corners[1].drawn - at;
    vec2 r = corners[2].drawn - at;
    vec3 barycentrics = vec3(cross2(q, r) / widening(corners[0].drawn_depth), cross2(r, p) / widening(corners[1].drawn_depth),
                       cross2(p, q) / widening(corners[2].drawn_depth));
    float sum = barycentrics.x + barycentrics.y + barycentrics.z;
    barycentrics = sum != 0.0 ? barycentrics / sum : vec3(1.0 / 3.0);
    vec2 where = barycentrics.x * places[0] + barycentrics.y * places[1] + barycentrics.z * places[2];
    float moved = barycentrics.x * corners[0].drawn_time + barycentrics.y * corners[1].drawn_time + barycentrics.z * corners[2].drawn_time;
    return Fragment(base, place, vec3(1.0 - where.x - where.y, where), moved, triangle.xyz, barycentrics);
}
