// The list of occupied tiles in order, in one workgroup, and the arguments of what works on them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "group.glsl"
#include "lanes.glsl"
layout(std430, binding = 1) readonly buffer TileGroups { uint tile_groups[]; };
layout(std430, binding = 2) writeonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 3) buffer ControlBuffer { Control control; };
layout(std430, binding = 5) readonly buffer HistoryBuffer { History history; };
layout(std430, binding = 4) writeonly buffer LuminanceParts { uvec4 luminance_parts[]; };
layout(push_constant) uniform OccupiedConstants {
    uint parts;         // dispatches that the light-space lists may need
    uint part_entries;  // entries that each of them works on
} constants;

shared uint sums[gl_WorkGroupSize.x];

bool is_occupied(uint tile) {
    uint any_group = 0u;
    for (uint i = 0u; i < GROUP_WORDS; ++i) {
        any_group |= tile_groups[GROUP_WORDS * tile + i];
    }
    return any_group != 0u;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uvec2 run = own_run(params.tiles.x * params.tiles.y);
    uint sum = 0u;
    for (uint tile = run.x; tile < run.y; ++tile) {
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
    for (uint tile = run.x; tile < run.y; ++tile) {
        if (is_occupied(tile)) {
            occupied_tiles[before++] = tile;
        }
    }
    if (lane == 0u) {
        control.tile_groups = uvec4(total, 1u, 1u, 0u);
        control.tile_draw = uvec4(QUAD_VERTICES, total, 0u, 0u);
    }
    for (uint part = lane; part < constants.parts; part += gl_WorkGroupSize.x) {
        bool needed = part == 0u || history.longest > part * constants.part_entries;
        luminance_parts[part] = uvec4(needed ? total : 0u, 1u, 1u, 0u);
    }
}
