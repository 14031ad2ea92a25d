// Distance of what is drawn in pixels, squared.
float distance2(vec2 from, vec2 to) {
    precise vec2 way = to - from;
    precise float square = way.x * way.x + way.y * way.y;
    return square;
}

// The vertex that an edge has at a quarter, half or three quarters of it (1, 2, 3).
Vertex vertex_between(uint a, uint b, uint where) {
    uint label = max(vertices[a].place.x, vertices[b].place.x);
    vec4 motion = state_at(a, b, where, params.model.y).motion;
    vec2 extent = extent_of(motion, label);
    float added = between(vertices[a].extent.z, vertices[b].extent.z, where);
    float moved = label == 0u ? 1.0 : shifted(moved_by(extent, label), added);
    State state = state_at(a, b, where, moved);
    return Vertex(motion, vec4(extent, added, moved), vec4(state.motion.xy, state.depth, moved), uvec4(label, 0u, 0u, 0u));
}
