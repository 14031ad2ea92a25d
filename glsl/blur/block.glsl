// What the triangles of a workgroup become, summed up: triangles that are divided further, and how many of them they come
// from.
shared uvec2 sums[BLOCK];

// Sums of the lanes before, and of all.
uvec4 sum_block(uvec2 own) {
    uint lane = gl_LocalInvocationID.x;
    sums[lane] = own;
    barrier();
    for (uint reach = 1u; reach < BLOCK; reach *= 2u) {
        uvec2 before = lane >= reach ? sums[lane - reach] : uvec2(0u);
        barrier();
        sums[lane] += before;
        barrier();
    }
    return uvec4(sums[lane] - own, sums[BLOCK - 1u]);
}

// Triangles that one becomes, and 1, if any of its edges is split.
uvec2 parts_of(uint state) {
    uint split = (state >> OPEN_SHIFT) != 0u ? state >> SPLIT_SHIFT & 7u : 0u;
    return split == 0u ? uvec2(0u) : uvec2(1u + bitCount(split), 1u);
}
