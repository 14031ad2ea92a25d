// The list of occupied tiles in order, in one workgroup, and the arguments of what works on them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Cells { uint cell_ends[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 3) writeonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 4) writeonly buffer ActiveTiles { uint active_tiles[]; };
layout(std430, binding = 5) writeonly buffer TileRepetitions { uint tile_repetitions[]; };
layout(std430, binding = 6) writeonly buffer PartArguments { uvec4 part_arguments[]; };
#include "cells.glsl"
#include "lists.glsl"
#include "mask_level.glsl"
#include "parts.glsl"
#include "share.glsl"

bool is_occupied(uint tile) {
    bool any_entry = params.is_skipping == 0u;
    for (uint level = 0u; level < params.cell_level_count; ++level) {
        uvec2 range = list_range(tile_at(tile), level);
        any_entry = any_entry || range.x < range.y;
    }
    return any_entry;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uvec2 share = share_of_list(params.tiles.x * params.tiles.y);
    uint sum = 0u;
    for (uint tile = share.x; tile < share.y; ++tile) {
        sum += is_occupied(tile) ? 1u : 0u;
    }
    uvec2 sums = prefix_sum(sum);
    uint at = sums.x;
    uint total = sums.y;
    for (uint tile = share.x; tile < share.y; ++tile) {
        if (is_occupied(tile)) {
            occupied_tiles[at] = tile;
            active_tiles[at] = tile;
            ++at;
        }
        tile_repetitions[tile] = params.repetitions_before + stage.repetitions;
    }
    if (lane == 0u) {
        control.tile_groups = uvec4(total, 1u, 1u, 0u);
        control.active_groups = control.tile_groups;
        control.tile_draw = uvec4(QUAD_VERTICES, total, 0u, 0u);
    }
    write_parts(lane, total);
}
