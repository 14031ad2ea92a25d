// How the host's depth images hold depth, with what `params` says of the view.

const uint UNORM_16 = 0u;  // what they are made of
const uint UNORM_24 = 1u;
const uint FLOATS = 2u;

// What they hold at a view depth.
float host_depth(float depth) {
    vec2 terms = params.depth_terms;
    return clamp(terms.x + (params.is_orthographic != 0u ? terms.y * depth : terms.y / depth), 0.0, 1.0);
}

// The view depth of what they hold, by such terms.
float view_depth(vec2 terms, float held) {
    float rest = held - terms.x;
    return params.is_orthographic != 0u ? rest / terms.y : terms.y / rest;
}
