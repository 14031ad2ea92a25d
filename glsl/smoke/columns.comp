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

// The sums of the group, or of the plane behind its pixels, and of the plane before them.
float numerator_before[TAPS];
float denominator_before[TAPS];

// Rows of a block, of a group or plane.
void load_block(uint block_y, uint tile_x, uint x, uint group, out float values[TAPS], out float masks[TAPS]) {
    uint slot = slot_of(block_y / TILE_BLOCKS * params.tiles.x + tile_x, group);
    uint first = slot + block_y % TILE_BLOCKS * BLOCK * TILE + x % TILE;
    uint rows = min(BLOCK, params.size.y - min(block_y * BLOCK, params.size.y));
    for (uint i = 0u; i < BLOCK; ++i) {
        vec2 sums = i < rows ? row_sums[first + i * TILE] : vec2(0.0);
        values[i] = sums.x;
        masks[i] = sums.y;
    }
}

void add_blocks(float w[2 * TAPS - 1], uvec2 block, uint tile_x, uint x, uint group) {
    uint beside = reached[block.y * blocks_of_tiles().x + block.x].beside;
    float values[TAPS];
    float masks[TAPS];
    if (SOFT && (beside & adding_bits(group - 1u)) != 0u) {
        load_block(block.y, tile_x, x, group - 1u, values, masks);
        add_values(numerator_before, w, values);
        add_values(denominator_before, w, masks);
    }
    if ((beside & adding_bits(group)) != 0u) {
        load_block(block.y, tile_x, x, group, values, masks);
        add_taps(w, values, masks);
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
    clear_sums();
    for (int o = 0; o < TAPS; ++o) {
        numerator_before[o] = 0.0;
        denominator_before[o] = 0.0;
    }
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int y = int(at.y) + side * distance;
            if (y >= 0 && y < int(blocks_of_tiles().y) && (distance > 0 || side > 0)) {
                add_blocks(on_side(w, side), uvec2(at.x, y), tile_x, x, group);
            }
        }
    }
    for (uint o = 0u; o < BLOCK; ++o) {
        uint y = at.y * BLOCK + o;
        uint index = pixel_index(uvec2(x, y));
        if (y < params.size.y && pixel_id(pixels[index]) == group) {
            vec2 sums = vec2(numerator[o], denominator[o]);
            if (SOFT) {
                vec2 shares = plane_shares(ranges, depth[index], group);
                sums = shares.x * vec2(numerator_before[o], denominator_before[o]) + shares.y * sums;
            }
            if (CHANNEL != NO_CHANNEL) {
                smooth_channels[channel_index(CHANNEL, index)] = sums.x / sums.y;
            } else {
                smooth_luminance[index] = sums.x / sums.y;
            }
        }
    }
}
