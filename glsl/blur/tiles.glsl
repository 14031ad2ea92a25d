// Tiles of 8 x 8 pixels that are worked on. Words of `tiles`: their number; from word 4 on dispatches over them, four words
// each; from word 16 on whether each tile of the picture is one; their list; and what each pixel may show.

const uint ROW = 64u;        // workgroups of a row of a dispatch over tiles
const uint DISPATCHES = 3u;  // of one workgroup a tile, of two and of four
const uint NO_PLACE = 1u << 20;

uint flag_of(uint tile) {
    return 16u + tile;
}

uint place_of(uint place) {
    return 16u + params.tiles.x * params.tiles.y + place;
}

uint cover_of(ivec2 pixel) {
    return 16u + 2u * params.tiles.x * params.tiles.y + uint(pixel.y) * params.size.x + uint(pixel.x);
}

// The first pixel of the tile that a workgroup works on; far outside of the picture where there is nothing to do.
uvec2 tile_origin(uvec3 group) {
    uint place = group.y * ROW + group.x;
    uint tile = place < tiles[0] ? tiles[place_of(place)] : 0u;
    uvec2 origin = 8u * uvec2(tile % params.tiles.x, tile / params.tiles.x);
    return place < tiles[0] ? origin : uvec2(NO_PLACE);
}
