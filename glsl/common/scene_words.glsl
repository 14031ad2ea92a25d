// A depth image of the host's, copied: rows without gaps.
#include "host_depth.glsl"
layout(std430, binding = 1) readonly buffer SceneWords { uint scene_words[]; };

// What it holds at a pixel.
float scene_word(uint kind, uint pixel) {
    uint word = scene_words[kind == UNORM_16 ? pixel / 2u : pixel];
    uint half_word = (pixel & 1u) == 0u ? word & 0xffffu : word >> 16u;
    return kind == UNORM_16 ? float(half_word) / 65535.0
        : kind == UNORM_24 ? float(word & 0xffffffu) / 16777215.0 : uintBitsToFloat(word);
}
