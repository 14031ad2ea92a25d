// Hulls as the farthest points in equally many directions.
const uint DIRECTIONS = 256u;      // of a part's outline; and points of a chunk of a part
const float DIRECTION_STEP = 0.0245436926061702596754894014318711; // radians, 2 pi / 256

vec2 direction_at(uint index) {
    float angle = float(index) * DIRECTION_STEP;
    return vec2(cos(angle), sin(angle));
}
