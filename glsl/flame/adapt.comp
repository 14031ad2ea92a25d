// The list of the tiles that go on, in order, and the arguments of their next stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 4) buffer TileRepetitions { uint tile_repetitions[]; };
layout(std430, binding = 5) writeonly buffer ActiveTiles { uint active_tiles[]; };
layout(std430, binding = 6) writeonly buffer PartArguments { uvec4 part_arguments[]; };
layout(std430, binding = 7) readonly buffer TileSums { uint block_sums[]; };
#include "mask_level.glsl"
#include "parts.glsl"
#include "going_on.glsl"
#define SCAN_TYPE uint
#define SCAN_BLOCKS
#include "common/scan.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    bool is_one = goes_on(index);
    Scan blocks = scan_blocks(gl_WorkGroupID.x, gl_NumWorkGroups.x);
    uint at = blocks.before + scan_workgroup(is_one ? 1u : 0u).before;
    if (is_one) {
        uint tile = occupied_tiles[index];
        active_tiles[at] = tile;
        tile_repetitions[tile] = stage.done + stage.repetitions;
    }
    if (gl_WorkGroupID.x == 0u) {
        if (gl_LocalInvocationID.x == 0u) {
            control.active_groups = uvec4(blocks.all, 1u, 1u, 0u);
        }
        write_parts(control.segments, control.part_repetitions, blocks.all);
    }
}
