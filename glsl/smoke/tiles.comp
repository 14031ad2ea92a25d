// Which groups each block and each tile holds. A block keeps one bit for all groups that are equal modulo 32: enough to
// skip by, since skipping work for groups that are not there changes nothing.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 8, local_size_y = 16) in;
layout(binding = 1, r32ui) uniform readonly uimage2D seen;
layout(std430, binding = 2) writeonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 3) writeonly buffer TileGroups { uint tile_groups[]; };

shared uint block_bits[16];
shared uint tile_bits[8];

void main() {
    uint lane = gl_LocalInvocationIndex;
    if (lane < 16u) {
        block_bits[lane] = 0u;
    }
    if (lane < 8u) {
        tile_bits[lane] = 0u;
    }
    barrier();
    uvec2 tile = gl_WorkGroupID.xy;
    uint block = gl_LocalInvocationID.y;
    uvec2 corner = tile * TILE + uvec2(block % TILE_BLOCKS, block / TILE_BLOCKS) * BLOCK;
    uint y = corner.y + gl_LocalInvocationID.x;
    if (y < params.size.y) {
        uint last = 0u;
        uint bits = 0u;
        for (uint x = corner.x; x < min(corner.x + BLOCK, params.size.x); ++x) {
            uint id = imageLoad(seen, ivec2(x, y)).x & 255u;
            if (id != last && id != 0u) {
                bits |= 1u << (id & 31u);
                atomicOr(tile_bits[id / 32u], 1u << (id & 31u));
            }
            last = id;
        }
        if (bits != 0u) {
            atomicOr(block_bits[block], bits);
        }
    }
    barrier();
    uint tile_index = tile.y * params.tiles.x + tile.x;
    if (lane < 8u) {
        tile_groups[8u * tile_index + lane] = tile_bits[lane];
    }
    if (lane < 16u) {
        uvec2 at = tile * TILE_BLOCKS + uvec2(lane % TILE_BLOCKS, lane / TILE_BLOCKS);
        block_masks[at.y * (params.tiles.x * TILE_BLOCKS) + at.x] = block_bits[lane];
    }
}
