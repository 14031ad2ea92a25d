// For each block the groups within the Gaussian's window, from block masks.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "reach.glsl"
#include "screen.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 2) writeonly buffer Reached { Reach reached[]; };

void main() {
    ivec2 blocks = ivec2(blocks_of_tiles());
    int across = blocks.x;
    int down = blocks.y;
    int index = int(gl_GlobalInvocationID.x);
    if (index >= across * down) {
        return;
    }
    int x = index % across;
    int y = index / across;
    int window = int(params.window_blocks);
    Reach groups = Reach(0u, 0u);
    for (int i = max(x - window, 0); i <= min(x + window, across - 1); ++i) {
        groups.beside |= block_masks[y * across + i];
    }
    for (int i = max(y - window, 0); i <= min(y + window, down - 1); ++i) {
        groups.above |= block_masks[i * across + x];
    }
    reached[index] = groups;
}
