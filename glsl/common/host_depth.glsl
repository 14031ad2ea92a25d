// What the host's depth image holds at a view depth. Terms: x + y / view depth.
float host_depth(vec2 terms, float depth) {
    return clamp(terms.x + terms.y / depth, 0.0, 1.0);
}

// The view depth of what the host's depth image holds.
float view_depth(vec2 terms, float held) {
    return terms.y / (held - terms.x);
}
