// Normals of frames i, i + 1, i - 1 and i + 2 (1, 2, 0, 3) come in this order: the outer ones only where they are needed.

uint frame_of_normals(uint place) {
    return place < 2u ? place + 1u : place == 2u ? 0u : 3u;
}

uint place_of_normals(uint frame) {
    return frame == 0u ? 2u : frame == 3u ? 3u : frame - 1u;
}
