// How many tiles of each block are occupied, which they are, and the longest list of any.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Cells { uint cell_ends[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 3) writeonly buffer TileSums { uint block_sums[]; };
layout(std430, binding = 4) writeonly buffer TileFire { uint tile_fire[]; };
#include "cells.glsl"
#include "lists.glsl"
#define SCAN_TYPE uint
#include "common/scan.glsl"

shared uint longest;

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (gl_LocalInvocationID.x == 0u) {
        longest = 0u;
    }
    barrier();
    uint entries = tile < params.tiles.x * params.tiles.y ? entries_of(tile_at(tile)) : 0u;
    atomicMax(longest, entries);
    bool has_fire = is_occupied(tile, entries);
    if (tile < params.tiles.x * params.tiles.y) {
        tile_fire[tile] = has_fire ? 1u : 0u;
    }
    uint occupied = scan_workgroup(has_fire ? 1u : 0u).all;
    if (gl_LocalInvocationID.x == 0u) {
        block_sums[gl_WorkGroupID.x] = occupied;
        atomicMax(control.listed, longest);
    }
}
