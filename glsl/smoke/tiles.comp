// Which groups each block and each tile holds, and whether smoke touches a tile from outside, where it may cover its pixels
// in part. A block keeps one bit for all groups that are equal modulo 32: enough to
// skip by, since skipping work for groups that are not there changes nothing.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "group.glsl"
#include "screen.glsl"
layout(constant_id = 0) const bool ANTIALIASED = false;  // smoke covers pixels in part
layout(local_size_x = BLOCK, local_size_y = TILE_BLOCKS * TILE_BLOCKS) in;
layout(binding = 1, r32ui) uniform readonly uimage2D seen;
layout(std430, binding = 2) writeonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 3) writeonly buffer TileGroups { uint tile_groups[]; };

shared uint block_bits[gl_WorkGroupSize.y];
shared uint tile_bits[GROUP_WORDS];

const uint RING = TILE + 1u;  // pixels around a tile, on each side

// A pixel around a tile, of 4 * RING: each side begins at a corner.
ivec2 ring_pixel(uint tile, uint index) {
    int along = int(index % RING) - 1;
    uint side = index / RING;
    int far = int(TILE);
    ivec2 at = side == 0u ? ivec2(along, -1) : side == 1u ? ivec2(far, along)
             : side == 2u ? ivec2(far - 1 - along, far) : ivec2(-1, far - 1 - along);
    return at + ivec2(tile_at(tile) * TILE);
}

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
    for (uint i = lane; ANTIALIASED && i < 4u * RING; i += gl_WorkGroupSize.x * gl_WorkGroupSize.y) {
        ivec2 at = ring_pixel(tile, i);
        if (is_in_picture(uvec2(at)) && imageLoad(seen, at).x != 0u) {
            atomicOr(tile_bits[TOUCHED / 32u], group_bit(TOUCHED));
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
