// What the host's depth image holds at a view depth. Terms: x + y / view depth.
float host_depth(vec2 terms, float depth) {
    return clamp(terms.x + terms.y / depth, 0.0, 1.0);
}
