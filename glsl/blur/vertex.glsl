// Distance of what is drawn in pixels, squared.
float distance2(vec4 from, vec4 to) {
    precise vec2 way = to.xy / to.z - from.xy / from.z;
    precise float square = way.x * way.x + way.y * way.y;
    return square;
}

// The vertex that an edge has at a quarter, half or three quarters of it (1, 2, 3).
Vertex vertex_between(uint a, uint b, uint where) {
    uint label = max(vertices[a].place.x, vertices[b].place.x);
    vec4 motion = motion_at(a, b, where);
    vec2 extent = extent_of(motion, label);
    float added = between(vertices[a].extent.z, vertices[b].extent.z, where);
    precise float sum = moved_by(extent, label) + added;
    float moved = label == 0u ? 1.0 : clamp(sum, 1.0 - params.model.x, 1.0);
    return Vertex(motion, vec4(extent, added, moved), vec4(clip_at(a, b, where, moved), moved), uvec4(label, 0u, 0u, 0u));
}
