// What vertices say of a triangle of the mesh: `base` has its corners.

// Whether it stays where it is.
bool is_still(uvec4 base) {
    return max(max(vertices[base.x].cluster, vertices[base.y].cluster), vertices[base.z].cluster) == 0u;
}

// Barycentrics of a vertex in it, of its second and its third corner.
vec2 barycentrics_of(uint vertex, uvec4 base) {
    vec2 own = vertices[vertex].barycentrics;
    return own.x >= 0.0 ? own
        : vec2(base.y == vertex ? 1.0 : 0.0, base.z == vertex ? 1.0 : 0.0);
}
