// The list of occupied tiles in order, and the arguments of what works on them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "occupied.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 2) writeonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 3) buffer ControlBuffer { Control control; };
layout(std430, binding = 4) writeonly buffer LuminanceParts { uvec4 luminance_parts[]; };
layout(std430, binding = 5) readonly buffer TileSums { uint block_sums[]; };
layout(push_constant) uniform OccupiedConstants {
    uint parts;         // dispatches that the light-space lists may need
    uint part_entries;  // entries that each of them works on
} constants;
#define SCAN_TYPE uint
#define SCAN_BLOCKS
#include "common/scan.glsl"

void main() {
    bool occupied = is_occupied(gl_GlobalInvocationID.x);
    Scan blocks = scan_blocks(gl_WorkGroupID.x, gl_NumWorkGroups.x);
    uint at = blocks.before + scan_workgroup(occupied ? 1u : 0u).before;
    if (occupied) {
        occupied_tiles[at] = gl_GlobalInvocationID.x;
    }
    if (gl_WorkGroupID.x > 0u) {
        return;
    }
    if (gl_LocalInvocationID.x == 0u) {
        control.tile_groups = uvec4(blocks.all, 1u, 1u, 0u);
        control.tile_draw = uvec4(QUAD_VERTICES, blocks.all, 0u, 0u);
    }
    // A ray meets one list of each level.
    uint longest = 0u;
    for (uint level = 0u; level < params.light_levels; ++level) {
        longest += control.longest[level];
    }
    for (uint part = gl_LocalInvocationID.x; part < constants.parts; part += gl_WorkGroupSize.x) {
        bool needed = part == 0u || longest > part * constants.part_entries;
        luminance_parts[part] = uvec4(needed ? blocks.all : 0u, 1u, 1u, 0u);
    }
}
