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
    vec4 motion = vec4(seen.position, seen.velocity);
    return min(min(seen.depth, begin), end) > 0.0 && !any(isinf(motion)) && !any(isnan(motion));
}

// k, l, what smoothing adds and k'.
vec4 extent_at(uint vertex) {
    return vec4(vertices[vertex].k, vertices[vertex].l, vertices[vertex].smoothing, vertices[vertex].time);
}

// The same between clusters: means of the ends'.
vec4 extent_between(uint a, uint b, uint where) {
    precise vec4 middle = (extent_at(a) + extent_at(b)) * 0.5;
    if (where != 2u && !is_usable(a, b, 2u, state_at(a, b, 2u, params.reference_time))) {
        middle = vec4(1.0, 0.0, 0.0, 1.0);
    }
    precise vec4 quarter = ((where == 1u ? extent_at(a) : extent_at(b)) + middle) * 0.5;
    return where == 2u ? middle : quarter;
}

// The vertex that an edge has at a quarter, half or three quarters of it (1, 2, 3).
Vertex vertex_between(uint a, uint b, uint where) {
    State seen = state_at(a, b, where, params.reference_time);
    uint label = vertices[a].cluster == vertices[b].cluster ? vertices[a].cluster : BETWEEN;
    if (!is_usable(a, b, where, seen)) {
        seen.position = vec2(0.0);
        seen.velocity = vec2(0.0);
        label = 0u;
    }
    float share = between(vertices[a].share, vertices[b].share, where);
    vec4 extent = vec4(1.0, 0.0, 0.0, 1.0);
    if (label == BETWEEN) {
        extent = extent_between(a, b, where);
    } else if (label != 0u) {
        extent.xy = extent_of(seen.position, seen.velocity, label);
        extent.z = between(vertices[a].smoothing, vertices[b].smoothing, where);
        extent.w = shifted(moved_by(extent.xy, label, share), extent.z);
    }
    State state = state_at(a, b, where, extent.w);
    return Vertex(seen.position, seen.velocity, extent.x, extent.y, extent.z, extent.w, state.position, state.depth, extent.w,
                  label, share, vec2(0.0));
}
