// Hulls as the farthest points in many directions, which lie on a square that stands on its corner: nothing but + - * / finds
// the nearest of them.
const uint DIRECTIONS = 256u;        // of a part's outline; and points of a chunk of a part
const float LARGEST_STEP = 0.03125;  // radians between two of them, at most: 8 / DIRECTIONS
const uint DIRECTIONS_A_SIDE = 64u;  // of the square

// Increases as a vector turns from x to y, 0 to 4.
float turn_of(vec2 v) {
    float p = v.y / (abs(v.x) + abs(v.y));
    return v.x < 0.0 ? 2.0 - p : v.y < 0.0 ? 4.0 + p : p;
}

// Of any length.
vec2 direction_at(uint index) {
    float share = float(index % DIRECTIONS_A_SIDE) / float(DIRECTIONS_A_SIDE);
    vec2 first = vec2(1.0 - share, share);
    uint quarter = index / DIRECTIONS_A_SIDE;
    if (quarter < 2u) {
        return quarter == 0u ? first : vec2(-first.y, first.x);
    }
    return quarter == 2u ? -first : vec2(first.y, -first.x);
}

// The one nearest to a vector, in turns.
uint nearest_direction(vec2 v) {
    return uint(turn_of(v) * float(DIRECTIONS_A_SIDE) + 0.5) % DIRECTIONS;
}
