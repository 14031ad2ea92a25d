// What the masked Gaussian works on, for one batch of groups: (tile, group) pairs whose row sums are needed (the group occurs within the window
// above or below); and those whose pixels are filtered (the group occurs in the tile). With the mask "soft" row sums are
// those of planes: needed where pixels before or behind the plane are filtered. Pixels of a group need the plane of its
// number, which is in the same batch, and the one before, which is in memory still if it was the last of the batch before.
#include "mask.glsl"
#include "screen.glsl"
layout(std430, binding = 1) readonly buffer TileGroups { uint tile_groups[]; };
layout(push_constant) uniform ItemsConstants {
    uint batch;
    uint first_group;
    uint group_count;
    uint capacity;     // entries of a batch
} constants;

bool has(uint tile, uint group) {
    return (tile_groups[GROUP_WORDS * tile + group / 32u] & group_bit(group)) != 0u;
}

// 1 if a pair's row sums are needed, and 1 if its pixels are filtered.
uvec2 needs_of(uint index) {
    uint tiles = params.tiles.x * params.tiles.y;
    if (index >= tiles * constants.group_count) {
        return uvec2(0u);
    }
    uint tile = index % tiles;
    uint group = constants.first_group + index / tiles;
    bool column = has(tile, group);
    bool row = false;
    uvec2 at = tile_at(tile);
    int reach = (int(params.window_blocks) + int(TILE_BLOCKS) - 1) / int(TILE_BLOCKS);
    int y = int(at.y);
    for (int other = max(y - reach, 0); other <= min(y + reach, int(params.tiles.y) - 1) && !row; ++other) {
        uint beside = uint(other) * params.tiles.x + at.x;
        row = has(beside, group) || SOFT && has(beside, group + 1u);
    }
    return uvec2(row ? 1u : 0u, column ? 1u : 0u);
}
