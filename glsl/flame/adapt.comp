// The list of the tiles that go on, in order, in one workgroup, and the arguments of their next stage.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 3) readonly buffer TileOpen { uint tile_open[]; };
layout(std430, binding = 4) buffer TileRepetitions { uint tile_repetitions[]; };
layout(std430, binding = 5) writeonly buffer ActiveTiles { uint active_tiles[]; };
layout(std430, binding = 6) writeonly buffer PartArguments { uvec4 part_arguments[]; };
#include "mask_level.glsl"
#include "parts.glsl"
#include "share.glsl"

bool goes_on(uint tile) {
    return tile_open[tile] != 0u && tile_repetitions[tile] == stage.done;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uvec2 share = share_of_list(control.tile_groups.x);
    uint sum = 0u;
    for (uint i = share.x; i < share.y; ++i) {
        sum += goes_on(occupied_tiles[i]) ? 1u : 0u;
    }
    uvec2 sums = prefix_sum(sum);
    uint at = sums.x;
    uint total = sums.y;
    for (uint i = share.x; i < share.y; ++i) {
        uint tile = occupied_tiles[i];
        if (goes_on(tile)) {
            active_tiles[at++] = tile;
            tile_repetitions[tile] = stage.done + stage.repetitions;
        }
    }
    if (lane == 0u) {
        control.active_groups = uvec4(total, 1u, 1u, 0u);
    }
    write_parts(lane, total);
}
