// Pixels, blocks and tiles of the picture.
#ifndef SCREEN
#define SCREEN

// Place of a pixel in buffers of the picture, row by row from the top.
uint pixel_index(uvec2 at) {
    return at.y * params.size.x + at.x;
}

// Negative coordinates, as unsigned ones, are not.
bool is_in_picture(uvec2 at) {
    return all(lessThan(at, params.size));
}

uvec2 tile_at(uint tile) {
    return uvec2(tile % params.tiles.x, tile / params.tiles.x);
}

// Blocks of all tiles across and down; those at the border may lie outside of the picture.
uvec2 blocks_of_tiles() {
    return params.tiles * TILE_BLOCKS;
}

// Block number `block` of a tile.
uvec2 block_at(uint tile, uint block) {
    return tile_at(tile) * TILE_BLOCKS + uvec2(block % TILE_BLOCKS, block / TILE_BLOCKS);
}

#endif
