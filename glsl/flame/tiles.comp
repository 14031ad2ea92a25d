// The list of occupied tiles in order, the parts that lists are worked on in, and the arguments of what works on them.
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
layout(std430, binding = 7) readonly buffer TileSums { uint block_sums[]; };
#include "cells.glsl"
#include "lists.glsl"
#include "mask_level.glsl"
#include "parts.glsl"
#define SCAN_TYPE uint
#define SCAN_BLOCKS
#include "common/scan.glsl"

void main() {
    uint tile = gl_GlobalInvocationID.x;
    bool exists = tile < params.tiles.x * params.tiles.y;
    bool is_listed = is_occupied(tile, exists ? entries_of(tile_at(tile)) : 0u);
    Scan blocks = scan_blocks(gl_WorkGroupID.x, gl_NumWorkGroups.x);
    uint at = blocks.before + scan_workgroup(is_listed ? 1u : 0u).before;
    if (is_listed) {
        occupied_tiles[at] = tile;
        active_tiles[at] = tile;
    }
    if (exists) {
        tile_repetitions[tile] = params.repetitions_before + stage.repetitions;
    }
    if (gl_WorkGroupID.x == 0u) {
        Parts parts = cut_lists();
        if (gl_LocalInvocationID.x == 0u) {
            control.segments = parts.segments;
            control.segment_entries = parts.segment_entries;
            control.part_repetitions = parts.repetitions;
            control.tile_groups = uvec4(blocks.all, 1u, 1u, 0u);
            control.active_groups = uvec4(blocks.all, 1u, 1u, 0u);
            control.tile_draw = uvec4(QUAD_VERTICES, blocks.all, 0u, 0u);
        }
        write_parts(parts.segments, parts.repetitions, blocks.all);
    }
}
