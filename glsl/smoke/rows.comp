// Row sums of one tile and one group or plane: numerator and denominator along x. Blocks that no column needs are left out.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "no_channel.glsl"
#include "gaussian.glsl"
#include "mask.glsl"
#include "channels.glsl"
layout(constant_id = 1) const uint CHANNEL = NO_CHANNEL;  // what is smoothed; none: luminance
layout(std430, binding = 3) readonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 4) readonly buffer RowItems { uint row_items[]; };
layout(std430, binding = 5) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 6) writeonly buffer RowSums { vec2 row_sums[]; };
layout(std430, binding = 7) readonly buffer Depth { float depth[]; };
layout(std430, binding = 8) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 9) readonly buffer Channels { float channels[]; };
layout(push_constant) uniform GaussianConstants { uint base; } constants;  // first entry of the batch
#include "coordinate.glsl"

// How much of a pixel the sums of a group or plane have.
float share_of(Ranges ranges, uint pixel, uint index, uint group) {
    uint id = pixel_id(pixel);
    if (SOFT) {
        vec2 shares = plane_shares(ranges, depth[index], id);
        float behind = id == group ? shares.y : 0.0;
        return id == group + 1u ? shares.x : behind;
    }
    return id == group ? 1.0 : 0.0;
}

void add_block(Ranges ranges, float w[2 * TAPS - 1], uint row, int first, uint group) {
    float values[TAPS];
    float masks[TAPS];
    for (int i = 0; i < TAPS; ++i) {
        uint x = uint(first + i);
        uint index = row + min(x, params.size.x - 1u);
        uint pixel = x < params.size.x ? pixels[index] : 0u;
        masks[i] = share_of(ranges, pixel, index, group);
        float value = pixel_luminance(pixel);
        if (CHANNEL != NO_CHANNEL) {
            // Where nothing is seen, nothing has been written.
            value = pixel_id(pixel) != 0u ? channels[channel_index(CHANNEL, index)] : 0.0;
        }
        values[i] = masks[i] * value;
    }
    add_taps(w, values, masks);
}

void main() {
    uint item = row_items[constants.base + gl_WorkGroupID.x];
    uint group = item & GROUP_MASK;
    uint tile = item >> GROUP_BITS;
    uint block = gl_LocalInvocationID.y;
    uvec2 at = block_at(tile, block);
    uint across = blocks_of_tiles().x;
    uint bits = adding_bits(group);
    Reach groups = reached[at.y * across + at.x];
    uint y = at.y * BLOCK + gl_LocalInvocationID.x;
    if ((groups.beside & bits) == 0u || (groups.above & bits) == 0u || y >= params.size.y) {
        return;
    }
    Ranges ranges = Ranges(control.group_start, control.groups_per_metre);
    clear_sums();
    for (int distance = int(params.window_blocks); distance >= 0; --distance) {
        float w[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int x = int(at.x) + side * distance;
            bool used = x >= 0 && x < int(across) && (distance > 0 || side > 0);
            if (used && (block_masks[at.y * across + uint(x)] & bits) != 0u) {
                add_block(ranges, on_side(w, side), y * params.size.x, x * int(BLOCK), group);
            }
        }
    }
    uint first = slot_of(tile, group) + slot_row(block, gl_LocalInvocationID.x);
    for (uint o = 0u; o < BLOCK; ++o) {
        row_sums[first + o] = vec2(numerator[o], denominator[o]);
    }
}
