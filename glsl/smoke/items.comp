// The pairs that are needed, in order.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "items.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 2) writeonly buffer RowItems { uint row_items[]; };
layout(std430, binding = 3) writeonly buffer ColumnItems { uint column_items[]; };
layout(std430, binding = 4) writeonly buffer ItemArguments { uvec4 item_arguments[]; };
layout(std430, binding = 5) readonly buffer ItemSums { uvec2 block_sums[]; };
#define SCAN_TYPE uvec2
#define SCAN_BLOCKS
#include "common/scan.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    uint tiles = params.tiles.x * params.tiles.y;
    uint base = constants.batch * constants.capacity;
    uvec2 needs = needs_of(index);
    Scan blocks = scan_blocks(gl_WorkGroupID.x, gl_NumWorkGroups.x);
    uvec2 at = blocks.before + scan_workgroup(needs).before;
    uint item = index % tiles << GROUP_BITS | (constants.first_group + index / tiles);
    if (needs.x > 0u) {
        row_items[base + at.x] = item;
    }
    if (needs.y > 0u) {
        column_items[base + at.y] = item;
    }
    if (index == 0u) {
        item_arguments[2u * constants.batch] = uvec4(blocks.all.x, 1u, 1u, 0u);
        item_arguments[2u * constants.batch + 1u] = uvec4(blocks.all.y, 1u, 1u, 0u);
    }
}
