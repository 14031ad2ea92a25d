// The lists of a tile, one a level of cells.

// Where the list of a tile's cell at a level begins and ends.
uvec2 list_range(uvec2 tile, uint level) {
    uint cell = cell_index(level, tile.x >> level, tile.y >> level) * params.bucket_count;
    uint first = cell == 0u ? 0u : cell_ends[cell - 1u];
    return uvec2(first, cell_ends[cell + params.bucket_count - 1u]);
}
