// Distance of what is drawn in pixels, squared.
float distance2(vec2 from, vec2 to) {
    precise vec2 way = to - from;
    precise float square = way.x * way.x + way.y * way.y;
    return square;
}

// Whether what an edge has at a place of it can be distorted: what is behind the camera is not.
bool is_usable(uint a, uint b, uint where, State seen) {
    float begin = start_of(a, b, where).z;
    precise float end = begin + offset_at(a, b, where, 1.0).off.z;
    return min(min(seen.depth, begin), end) > 0.0 && !any(isinf(seen.motion)) && !any(isnan(seen.motion));
}

// k, l, what smoothing adds and k' between clusters: means of the ends'.
vec4 extent_between(uint a, uint b, uint where) {
    precise vec4 middle = (vertices[a].extent + vertices[b].extent) * 0.5;
    if (where != 2u && !is_usable(a, b, 2u, state_at(a, b, 2u, params.model.y))) {
        middle = vec4(1.0, 0.0, 0.0, 1.0);
    }
    precise vec4 quarter = ((where == 1u ? vertices[a].extent : vertices[b].extent) + middle) * 0.5;
    return where == 2u ? middle : quarter;
}

// The vertex that an edge has at a quarter, half or three quarters of it (1, 2, 3).
Vertex vertex_between(uint a, uint b, uint where) {
    State seen = state_at(a, b, where, params.model.y);
    vec4 motion = seen.motion;
    uint label = vertices[a].place.x == vertices[b].place.x ? vertices[a].place.x : BETWEEN;
    if (!is_usable(a, b, where, seen)) {
        motion = vec4(0.0);
        label = 0u;
    }
    vec4 extent = vec4(1.0, 0.0, 0.0, 1.0);
    if (label == BETWEEN) {
        extent = extent_between(a, b, where);
    } else if (label != 0u) {
        extent.xy = extent_of(motion, label);
        extent.z = between(vertices[a].extent.z, vertices[b].extent.z, where);
        extent.w = shifted(moved_by(extent.xy, label), extent.z);
    }
    State state = state_at(a, b, where, extent.w);
    return Vertex(motion, extent, vec4(state.motion.xy, state.depth, extent.w), uvec4(label, 0u, 0u, 0u));
}
