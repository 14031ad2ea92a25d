// The list of tiles with fire in order, that of those that it is seen in, the parts that lists are worked on in, and the arguments of what works on them.
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
layout(std430, binding = 8) readonly buffer TileFire { uint tile_fire[]; };
layout(std430, binding = 9) writeonly buffer TileShown { uint tile_shown[]; };
layout(std430, binding = 10) writeonly buffer TileOpen { uint tile_open[]; };
layout(constant_id = 0) const uint REACH = 0;  // tiles around one with fire that it is smoothed into
#include "cells.glsl"
#include "lists.glsl"
#include "mask_level.glsl"
#include "parts.glsl"
#define SCAN_TYPE uint
#define SCAN_BLOCKS
#include "common/scan.glsl"

shared uint first_shown;

// Lists tiles that fire is smoothed into. Nothing depends on their order.
void list_shown(uint tile, bool exists) {
    uvec2 own = tile_at(tile);
    uvec2 low = uvec2(own.x - min(own.x, REACH), own.y - min(own.y, REACH));
    uvec2 high = min(own + REACH, params.tiles - 1u);
    bool is_shown = false;
    if (exists) {
        for (uint y = low.y; y <= high.y; ++y) {
            for (uint x = low.x; x <= high.x; ++x) {
                is_shown = is_shown || tile_fire[y * params.tiles.x + x] != 0u;
            }
        }
        tile_shown[tile] = (is_shown ? SHOWN : 0u) | (tile_fire[tile] != 0u ? BURNING : 0u);
        // Tiles without fire have no repetitions to go on with.
        tile_open[tile] = 0u;
    }
    Scan shown = scan_workgroup(is_shown ? 1u : 0u);
    if (gl_LocalInvocationID.x == 0u) {
        first_shown = atomicAdd(control.tile_groups.x, shown.all);
        atomicAdd(control.tile_draw.y, shown.all);
    }
    barrier();
    if (is_shown) {
        occupied_tiles[first_shown + shown.before] = tile;
    }
}

void main() {
    uint tile = gl_GlobalInvocationID.x;
    bool exists = tile < params.tiles.x * params.tiles.y;
    bool is_listed = is_occupied(tile, exists ? entries_of(tile_at(tile)) : 0u);
    Scan blocks = scan_blocks(gl_WorkGroupID.x, gl_NumWorkGroups.x);
    uint at = blocks.before + scan_workgroup(is_listed ? 1u : 0u).before;
    if (is_listed) {
        active_tiles[at] = tile;
    }
    if (REACH != 0u) {
        list_shown(tile, exists);
    } else if (is_listed) {
        occupied_tiles[at] = tile;
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
            control.active_groups = uvec4(blocks.all, 1u, 1u, 0u);
            if (REACH == 0u) {
                control.tile_groups = uvec4(blocks.all, 1u, 1u, 0u);
                control.tile_draw = uvec4(QUAD_VERTICES, blocks.all, 0u, 0u);
            }
        }
        write_parts(parts.segments, parts.repetitions, blocks.all);
    }
}
