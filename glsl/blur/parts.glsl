// Triangles that one becomes, and 1, if any of its edges is split.
uvec2 parts_of(uint state) {
    uint split = (state >> OPEN_SHIFT) != 0u ? state >> SPLIT_SHIFT & 7u : 0u;
    return split == 0u ? uvec2(0u) : uvec2(1u + bitCount(split), 1u);
}
