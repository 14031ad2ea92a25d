// The list of occupied tiles in order, in one workgroup, and the arguments of what works on them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer TileGroups { uint tile_groups[]; };
layout(std430, binding = 2) writeonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 3) buffer ControlBuffer { Control control; };
layout(std430, binding = 5) readonly buffer HistoryBuffer { History history; };
layout(std430, binding = 4) writeonly buffer LuminanceParts { uvec4 luminance_parts[]; };
layout(push_constant) uniform OccupiedConstants {
    uint parts;         // dispatches that the light-space lists may need
    uint part_entries;  // entries that each of them works on
} constants;

shared uint sums[256];

bool is_occupied(uint tile) {
    uint any_group = 0u;
    for (uint i = 0u; i < 8u; ++i) {
        any_group |= tile_groups[8u * tile + i];
    }
    return any_group != 0u;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint count = params.tiles.x * params.tiles.y;
    uint share = (count + 255u) / 256u;
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
    for (uint i = 0u; i < 256u; ++i) {
        before += i < lane ? sums[i] : 0u;
        total += sums[i];
    }
    for (uint tile = first; tile < last; ++tile) {
        if (is_occupied(tile)) {
            occupied_tiles[before++] = tile;
        }
    }
    if (lane == 0u) {
        control.tile_groups = uvec4(total, 1u, 1u, 0u);
        control.tile_draw = uvec4(4u, total, 0u, 0u);
    }
    for (uint part = lane; part < constants.parts; part += 256u) {
        bool needed = part == 0u || history.longest > part * constants.part_entries;
        luminance_parts[part] = uvec4(needed ? total : 0u, 1u, 1u, 0u);
    }
}
