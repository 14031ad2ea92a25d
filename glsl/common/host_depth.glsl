// How the host's depth images hold depth, with what `params` says of the view.

// What they hold at a view depth.
float host_depth(float depth) {
    vec2 terms = params.depth_terms;
    return clamp(terms.x + (params.is_orthographic != 0u ? terms.y * depth : terms.y / depth), 0.0, 1.0);
}

// The view depth of what they hold.
float view_depth(float held) {
    float rest = held - params.depth_terms.x;
    return params.is_orthographic != 0u ? rest / params.depth_terms.y : params.depth_terms.y / rest;
}
