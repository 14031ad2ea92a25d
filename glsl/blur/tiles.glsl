// Tiles of the picture that are worked on. Words of `tiles`: their number; dispatches over them, four words each; whether
// each tile of the picture is one; their list; and what each pixel may show.
#include "picture.glsl"

const uint TILE_DISPATCHES = 4u;  // where the dispatches begin
const uint TILE_FLAGS = 16u;      // where the flags begin
const uint ROW = 64u;        // workgroups of a row of a dispatch over tiles
const uint DISPATCHES = 3u;  // of one workgroup a tile, of two and of four
const uint NO_PLACE = 1u << 20;

// What a pixel may show, of frame f shifted by f.
const uint MOVING = 1u;     // it sees what moves
const uint OUTLINE = 16u;   // it may show the outline of what is before it
const uint COVERED = 256u;  // it may show the outline of what moves

uint flag_of(uint tile) {
    return TILE_FLAGS + tile;
}

uint place_of(uint place) {
    return TILE_FLAGS + params.tiles.x * params.tiles.y + place;
}

uint cover_of(ivec2 pixel) {
    return TILE_FLAGS + 2u * params.tiles.x * params.tiles.y + index_of(pixel);
}

// The first pixel of the tile that a workgroup works on; far outside of the picture where there is nothing to do.
uvec2 tile_origin(uvec3 group) {
    uint place = group.y * ROW + group.x;
    uint tile = place < tiles[0] ? tiles[place_of(place)] : 0u;
    uvec2 origin = TILE * uvec2(tile % params.tiles.x, tile / params.tiles.x);
    return place < tiles[0] ? origin : uvec2(NO_PLACE);
}
