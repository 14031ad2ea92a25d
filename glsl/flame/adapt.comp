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

shared uint sums[gl_WorkGroupSize.x];

bool goes_on(uint tile) {
    return tile_open[tile] != 0u && tile_repetitions[tile] == stage.done;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint count = control.tile_groups.x;
    uint share = (count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint first = min(lane * share, count);
    uint last = min(first + share, count);
    uint sum = 0u;
    for (uint i = first; i < last; ++i) {
        sum += goes_on(occupied_tiles[i]) ? 1u : 0u;
    }
    sums[lane] = sum;
    barrier();
    uint before = 0u;
    uint total = 0u;
    for (uint i = 0u; i < gl_WorkGroupSize.x; ++i) {
        before += i < lane ? sums[i] : 0u;
        total += sums[i];
    }
    for (uint i = first; i < last; ++i) {
        uint tile = occupied_tiles[i];
        if (goes_on(tile)) {
            active_tiles[before++] = tile;
            tile_repetitions[tile] = stage.done + stage.repetitions;
        }
    }
    if (lane == 0u) {
        control.active_groups = uvec4(total, 1u, 1u, 0u);
    }
    write_parts(lane, total);
}
