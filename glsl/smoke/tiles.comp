// Which groups each block and each tile holds. A block keeps one bit for all groups that are equal modulo 32: enough to
// skip by, since skipping work for groups that are not there changes nothing.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "group.glsl"
#include "screen.glsl"
layout(local_size_x = BLOCK, local_size_y = TILE_BLOCKS * TILE_BLOCKS) in;
layout(binding = 1, r32ui) uniform readonly uimage2D seen;
layout(std430, binding = 2) writeonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 3) writeonly buffer TileGroups { uint tile_groups[]; };

shared uint block_bits[gl_WorkGroupSize.y];
shared uint tile_bits[GROUP_WORDS];

void main() {
    uint lane = gl_LocalInvocationIndex;
    if (lane < gl_WorkGroupSize.y) {
        block_bits[lane] = 0u;
    }
    if (lane < GROUP_WORDS) {
        tile_bits[lane] = 0u;
    }
    barrier();
    uint tile = gl_WorkGroupID.y * params.tiles.x + gl_WorkGroupID.x;
    uint block = gl_LocalInvocationID.y;
    uvec2 corner = block_at(tile, block) * BLOCK;
    uint y = corner.y + gl_LocalInvocationID.x;
    if (y < params.size.y) {
        uint last = 0u;
        uint bits = 0u;
        for (uint x = corner.x; x < min(corner.x + BLOCK, params.size.x); ++x) {
            uint id = imageLoad(seen, ivec2(x, y)).x & GROUP_MASK;
            if (id != last && id != 0u) {
                bits |= group_bit(id);
                atomicOr(tile_bits[id / 32u], group_bit(id));
            }
            last = id;
        }
        if (bits != 0u) {
            atomicOr(block_bits[block], bits);
        }
    }
    barrier();
    if (lane < GROUP_WORDS) {
        tile_groups[GROUP_WORDS * tile + lane] = tile_bits[lane];
    }
    if (lane < gl_WorkGroupSize.y) {
        uvec2 at = block_at(tile, lane);
        block_masks[at.y * blocks_of_tiles().x + at.x] = block_bits[lane];
    }
}
