// What the masked Gaussian works on, for one batch of groups, in one workgroup: (tile, group) pairs whose row sums are
// needed (the group occurs within the window above or below), each with a slot of memory; and those whose pixels are
// filtered (the group occurs in the tile).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "group.glsl"
#include "screen.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer TileGroups { uint tile_groups[]; };
layout(std430, binding = 2) writeonly buffer RowItems { uint row_items[]; };
layout(std430, binding = 3) writeonly buffer ColumnItems { uint column_items[]; };
layout(std430, binding = 4) writeonly buffer RowSlots { uint row_slots[]; };
layout(std430, binding = 5) writeonly buffer ItemArguments { uvec4 item_arguments[]; };
layout(push_constant) uniform ItemsConstants {
    uint batch;
    uint first_group;
    uint group_count;
    uint capacity;     // entries of a batch
} constants;

shared uvec2 before[gl_WorkGroupSize.x];

bool has(uint tile, uint group) {
    return (tile_groups[GROUP_WORDS * tile + group / 32u] & group_bit(group)) != 0u;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint tiles = params.tiles.x * params.tiles.y;
    uint base = constants.batch * constants.capacity;
    int reach = (int(params.window_blocks) + int(TILE_BLOCKS) - 1) / int(TILE_BLOCKS);
    uvec2 total = uvec2(0u);
    for (uint start = 0u; start < tiles * constants.group_count; start += gl_WorkGroupSize.x) {
        uint index = start + lane;
        uint tile = index % tiles;
        uint group = constants.first_group + index / tiles;
        bool inside = index < tiles * constants.group_count;
        bool column = inside && has(tile, group);
        bool row = column;
        if (inside && !row) {
            uvec2 at = tile_at(tile);
            int y = int(at.y);
            for (int other = max(y - reach, 0); other <= min(y + reach, int(params.tiles.y) - 1) && !row; ++other) {
                row = has(uint(other) * params.tiles.x + at.x, group);
            }
        }
        uvec2 own = uvec2(row ? 1u : 0u, column ? 1u : 0u);
        before[lane] = own;
        for (uint width = 1u; width < gl_WorkGroupSize.x; width *= 2u) {
            barrier();
            uvec2 other = lane >= width ? before[lane - width] : uvec2(0u);
            barrier();
            before[lane] += other;
        }
        barrier();
        uvec2 at = total + before[lane] - own;
        uint item = tile << GROUP_BITS | group;
        if (row) {
            row_items[base + at.x] = item;
            row_slots[base + index] = at.x;
        }
        if (column) {
            column_items[base + at.y] = item;
        }
        total += before[gl_WorkGroupSize.x - 1u];
        barrier();
    }
    if (lane == 0u) {
        item_arguments[2u * constants.batch] = uvec4(total.x, 1u, 1u, 0u);
        item_arguments[2u * constants.batch + 1u] = uvec4(total.y, 1u, 1u, 0u);
    }
}
