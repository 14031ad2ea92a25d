// Smears that end in bristles: each ends somewhere on the way to the rear, if what is there is drawn back far enough.
const float HELD = 8.0;             // how much farther front what is held counts, for each frame
const float BRISTLES = 2.0;         // a tooth
const uint BRISTLE_SLOT = 131072u;  // where their random numbers begin

// The longest way without bristles, as a share of the way from the rear to the front. `back`: pixels that it is drawn back.
float longest_dry(float dry, float back) {
    return dry * clamp(back / params.dry_back, 0.0, 1.0);
}

// How far front a vertex is, and how many pixels it is drawn back. Where smoothing at seams holds it, another part goes on
// behind it: that is no end.
vec2 ends_of(Vertex vertex) {
    float back = max(1.0 - vertex.drawn_time, 0.0) * length(vertex.velocity);
    return vec2(min(vertex.k + HELD * vertex.smoothing, 1.0), back);
}
