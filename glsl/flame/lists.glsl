// The lists of a tile, one a level of cells.

// Where the list of a tile's cell at a level begins and ends.
uvec2 list_range(uvec2 tile, uint level) {
    uint cell = cell_index(level, tile.x >> level, tile.y >> level) * params.bucket_count;
    uint first = cell == 0u ? 0u : cell_ends[cell - 1u];
    return uvec2(first, cell_ends[cell + params.bucket_count - 1u]);
}

// Entries of all of a tile's lists.
uint entries_of(uvec2 tile) {
    uint entries = 0u;
    for (uint level = 0u; level < params.cell_level_count; ++level) {
        uvec2 range = list_range(tile, level);
        entries += range.y - range.x;
    }
    return entries;
}

// Whether a tile with so many entries is worked on.
bool is_occupied(uint tile, uint entries) {
    return tile < params.tiles.x * params.tiles.y && (entries > 0u || params.is_skipping == 0u);
}
