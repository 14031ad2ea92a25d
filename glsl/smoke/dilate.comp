// For each block the groups within the Gaussian's window to the sides (x) and above and below (y), from block masks.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer BlockMasks { uint block_masks[]; };
layout(std430, binding = 2) writeonly buffer Reached { uvec2 reached[]; };

void main() {
    int across = int(params.image.z * TILE_BLOCKS);
    int down = int(params.image.w * TILE_BLOCKS);
    int index = int(gl_GlobalInvocationID.x);
    if (index >= across * down) {
        return;
    }
    int x = index % across;
    int y = index / across;
    int window = int(params.filtering.y);
    uvec2 groups = uvec2(0u);
    for (int i = max(x - window, 0); i <= min(x + window, across - 1); ++i) {
        groups.x |= block_masks[y * across + i];
    }
    for (int i = max(y - window, 0); i <= min(y + window, down - 1); ++i) {
        groups.y |= block_masks[i * across + x];
    }
    reached[index] = groups;
}
