// Which tiles of the screen show anything.
#include "group.glsl"
layout(std430, binding = 1) readonly buffer TileGroups { uint tile_groups[]; };

bool is_occupied(uint tile) {
    if (tile >= params.tiles.x * params.tiles.y) {
        return false;
    }
    uint any_group = 0u;
    for (uint i = 0u; i < GROUP_WORDS; ++i) {
        any_group |= tile_groups[GROUP_WORDS * tile + i];
    }
    return any_group != 0u;
}
