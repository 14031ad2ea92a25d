// Column sums over the row sums of a tile, and the quotient for the pixels of one group: over the group's own sums, or, with
// the mask "soft", over those of the planes before and behind, each by the pixel's share in it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "no_channel.glsl"
#include "gaussian.glsl"
#include "mask.glsl"
#include "channels.glsl"
layout(constant_id = 1) const uint CHANNEL = NO_CHANNEL;  // as in the pass before
layout(std430, binding = 3) readonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 4) readonly buffer ColumnItems { uint column_items[]; };
layout(std430, binding = 5) readonly buffer RowSums { vec2 row_sums[]; };
layout(std430, binding = 6) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 7) writeonly buffer Smooth { float smooth_luminance[]; };
layout(std430, binding = 8) readonly buffer Depth { float depth[]; };
layout(std430, binding = 9) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 10) writeonly buffer SmoothChannels { float smooth_channels[]; };
layout(push_constant) uniform GaussianConstants { uint base; } constants;  // first entry of the batch
#include "coordinate.glsl"

void add_block(float w[2 * TAPS - 1], uint first, uint rows) {
    float values[TAPS];
    float masks[TAPS];
    for (uint i = 0u; i < BLOCK; ++i) {
        vec2 sums = i < rows ? row_sums[first + i * TILE] : vec2(0.0);
        values[i] = sums.x;
        masks[i] = sums.y;
    }
    add_taps(w, values, masks);
}

// Sums of a group or plane for the column of a block.
void add_column(uvec2 at, uint tile_x, uint x, uint group) {
    clear_sums();
    uint across = blocks_of_tiles().x;
    uint down = blocks_of_tiles().y;
    uint bits = adding_bits(group);
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int y = int(at.y) + side * distance;
            bool used = y >= 0 && y < int(down) && (distance > 0 || side > 0);
            if (used && (reached[uint(y) * across + at.x].beside & bits) != 0u) {
                uint first = slot_of(uint(y) / TILE_BLOCKS * params.tiles.x + tile_x, group);
                uint local = uint(y) % TILE_BLOCKS * BLOCK * TILE + x % TILE;
                uint rows = min(BLOCK, params.size.y - min(uint(y) * BLOCK, params.size.y));
                add_block(on_side(w, side), first + local, rows);
            }
        }
    }
}

void main() {
    uint item = column_items[constants.base + gl_WorkGroupID.x];
    uint group = item & GROUP_MASK;
    uint tile = item >> GROUP_BITS;
    uint block = gl_LocalInvocationID.y;
    uint tile_x = tile_at(tile).x;
    uvec2 at = block_at(tile, block);
    uint x = at.x * BLOCK + gl_LocalInvocationID.x;
    if ((block_masks[at.y * blocks_of_tiles().x + at.x] & group_bit(group)) == 0u || x >= params.size.x) {
        return;
    }
    Ranges ranges = Ranges(control.group_start, control.groups_per_metre);
    vec2 before[TAPS];
    if (SOFT) {
        add_column(at, tile_x, x, group - 1u);
        for (int o = 0; o < TAPS; ++o) {
            before[o] = vec2(numerator[o], denominator[o]);
        }
    }
    add_column(at, tile_x, x, group);
    for (uint o = 0u; o < BLOCK; ++o) {
        uint y = at.y * BLOCK + o;
        uint index = pixel_index(uvec2(x, y));
        if (y < params.size.y && pixel_id(pixels[index]) == group) {
            vec2 sums = vec2(numerator[o], denominator[o]);
            if (SOFT) {
                vec2 shares = plane_shares(ranges, depth[index], group);
                sums = shares.x * before[o] + shares.y * sums;
            }
            if (CHANNEL != NO_CHANNEL) {
                smooth_channels[channel_index(CHANNEL, index)] = sums.x / sums.y;
            } else {
                smooth_luminance[index] = sums.x / sums.y;
            }
        }
    }
}
