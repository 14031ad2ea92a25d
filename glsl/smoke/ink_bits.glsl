// Which pixels are ink: a bit a pixel, a word a row of a tile, in planes. Tiles that show nothing have none.
const uint WEAK = 0u;    // what is ink if it goes on from a strong one, and all strong ones
const uint STRONG = 1u;  // what is ink
const uint TRACED = 2u;  // what is ink, and what goes on from it
const uint INK_PLANES = 3u;
const uint INK_WORDS = INK_PLANES * TILE;  // of a tile
const uint WINDOW = 2u * TILE;             // side of what is seen of a tile and around it
const int MARGIN = int(TILE / 2u);         // how far that is beyond the tile
const uint TRACE_REACH = 16u;              // pixels that a weak line goes on; no more than the margin

uint ink_word(ivec2 tile, uint row, uint plane) {
    bool is_tile = all(greaterThanEqual(tile, ivec2(0))) && all(lessThan(tile, ivec2(params.tiles)));
    return is_tile ? ink_bits[INK_WORDS * uint(tile.y * int(params.tiles.x) + tile.x) + TILE * plane + row] : 0u;
}

// A row of the window around a tile, from left to right.
uvec2 window_row(uvec2 tile, uint row, uint plane) {
    uint below = row + TILE - uint(MARGIN);  // from the top of the tiles above
    ivec2 middle = ivec2(tile) + ivec2(0, int(below / TILE) - 1);
    uint left = ink_word(middle - ivec2(1, 0), below % TILE, plane);
    uint own = ink_word(middle, below % TILE, plane);
    uint right = ink_word(middle + ivec2(1, 0), below % TILE, plane);
    return uvec2(left >> MARGIN | own << MARGIN, own >> MARGIN | right << MARGIN);
}

// The part of a window's row that is the tile's.
uint own_part(uvec2 row) {
    return row.x >> MARGIN | row.y << MARGIN;
}

bool is_own_row(uint row) {
    return row >= uint(MARGIN) && row < uint(MARGIN) + TILE;
}
