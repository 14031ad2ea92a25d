// Distance of what is drawn in pixels, squared.
float distance2(vec2 from, vec2 to) {
    precise vec2 way = to - from;
    precise float square = way.x * way.x + way.y * way.y;
    return square;
}

// The vertex that an edge has at a quarter, half or three quarters of it (1, 2, 3). What is behind the camera is not
// distorted.
Vertex vertex_between(uint a, uint b, uint where) {
    State seen = state_at(a, b, where, params.model.y);
    vec4 motion = seen.motion;
    float begin = start_of(a, b, where).z;
    precise float end = begin + offset_at(a, b, where, 1.0).off.z;
    uint label = max(vertices[a].place.x, vertices[b].place.x);
    if (!(min(min(seen.depth, begin), end) > 0.0) || any(isinf(motion)) || any(isnan(motion))) {
        motion = vec4(0.0);
        label = 0u;
    }
    vec2 extent = vec2(1.0, 0.0);
    float added = 0.0;
    float moved = 1.0;
    if (label != 0u) {
        extent = extent_of(motion, label);
        added = between(vertices[a].extent.z, vertices[b].extent.z, where);
        moved = shifted(moved_by(extent, label), added);
    }
    State state = state_at(a, b, where, moved);
    return Vertex(motion, vec4(extent, added, moved), vec4(state.motion.xy, state.depth, moved), uvec4(label, 0u, 0u, 0u));
}
