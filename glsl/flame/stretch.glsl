// What a particle draws is drawn out along its motion on screen: places in the plane of the picture, from its centre, by the
// matrix 1 + w w^T. w lies along the motion, x right and y up; its square is how much longer that becomes.

// As it is kept: two halves.
vec2 stretch_of(uint halves) {
    return unpackHalf2x16(halves);
}

vec2 drawn_out(vec2 place, vec2 w) {
    return place + w * dot(w, place);
}

// Where a place has been drawn out from.
vec2 drawn_back(vec2 place, vec2 w) {
    return place - w * (dot(w, place) / (1.0 + dot(w, w)));
}

// How much farther a square reaches, across and down.
vec2 stretched_reach(vec2 w) {
    return 1.0 + w * w + abs(w.x * w.y);
}
