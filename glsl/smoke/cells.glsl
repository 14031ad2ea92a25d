// How the lists of light-space tiles lie in memory: face by face, from the coarsest level, each in buckets.
const uint BUCKETS = 64u;           // of a tile's list, by the distance from the light

uint first_cell(uint face, uint level) {
    return face * params.light_cells + ((1u << 2u * level) - 1u) / 3u;
}

// The level of a cell, from its place among the levels of its face.
uint level_of(uint cell) {
    return uint(findMSB(3u * (cell % params.light_cells) + 1u)) / 2u;
}
