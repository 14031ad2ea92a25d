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

shared uint sums[gl_WorkGroupSize.x];

bool is_occupied(uint tile) {
    uvec2 at = uvec2(tile % params.tiles.x, tile / params.tiles.x);
    bool any_entry = params.is_skipping == 0u;
    for (uint level = 0u; level < params.cell_level_count; ++level) {
        uvec2 range = list_range(at, level);
        any_entry = any_entry || range.x < range.y;
    }
    return any_entry;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint count = params.tiles.x * params.tiles.y;
    uint share = (count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint first = min(lane * share, count);
    uint last = min(first + share, count);
    uint sum = 0u;
    for (uint tile = first; tile < last; ++tile) {
        sum += is_occupied(tile) ? 1u : 0u;
    }
    sums[lane] = sum;
    barrier();
    uint before = 0u;
    uint total = 0u;
    for (uint i = 0u; i < gl_WorkGroupSize.x; ++i) {
        before += i < lane ? sums[i] : 0u;
        total += sums[i];
    }
    for (uint tile = first; tile < last; ++tile) {
        if (is_occupied(tile)) {
            occupied_tiles[before] = tile;
            active_tiles[before] = tile;
            ++before;
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
