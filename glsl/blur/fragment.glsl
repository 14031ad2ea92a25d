// What a sample sees of the distorted mesh.

layout(std430, binding = 16) readonly buffer Finished { uvec4 finished[]; };
layout(std430, binding = 17) readonly buffer Vertices { Vertex vertices[]; };

struct Fragment {
    uvec4 base;    // the mesh's triangle
    uint place;    // its number
    vec3 shares;   // of its corners
    float moved;   // k'
};

// Of a refined triangle at a place of the picture.
Fragment fragment_at(uint name, vec2 at) {
    uvec4 triangle = finished[name - 1u];
    uint place = triangle.w & BASE_MASK;
    uvec4 base = triangles[place];
    vec4 drawn[3];
    vec2 places[3];
    for (uint corner = 0u; corner < 3u; ++corner) {
        Vertex vertex = vertices[triangle[corner]];
        drawn[corner] = vertex.drawn;
        places[corner] = vertex.place.y == 0u ? uintBitsToFloat(vertex.place.zw)
            : vec2(base.y == triangle[corner] ? 1.0 : 0.0, base.z == triangle[corner] ? 1.0 : 0.0);
    }
    vec2 p = drawn[0].xy - at;
    vec2 q = drawn[1].xy - at;
    vec2 r = drawn[2].xy - at;
    vec3 shares = vec3(cross2(q, r) / drawn[0].z, cross2(r, p) / drawn[1].z, cross2(p, q) / drawn[2].z);
    float sum = shares.x + shares.y + shares.z;
    shares = sum != 0.0 ? shares / sum : vec3(1.0 / 3.0);
    vec2 where = shares.x * places[0] + shares.y * places[1] + shares.z * places[2];
    float moved = shares.x * drawn[0].w + shares.y * drawn[1].w + shares.z * drawn[2].w;
    return Fragment(base, place, vec3(1.0 - where.x - where.y, where), moved);
}

// Whether a triangle of the mesh stays where it is.
bool is_still(uvec4 base) {
    return max(max(vertices[base.x].place.x, vertices[base.y].place.x), vertices[base.z].place.x) == 0u;
}
