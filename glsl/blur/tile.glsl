// The tile that a workgroup works on.
layout(std430, binding = 30) readonly buffer Tiles { uint tiles[]; };
#include "tiles.glsl"

// Its first pixel; far outside of the picture where there is nothing to do.
uvec2 tile_origin() {
    uint place = gl_WorkGroupID.y * ROW + gl_WorkGroupID.x;
    uint tile = place < tiles[0] ? tiles[place_of(place)] : 0u;
    uvec2 origin = 8u * uvec2(tile % tiles_across(), tile / tiles_across());
    return place < tiles[0] ? origin : uvec2(NO_PLACE);
}
