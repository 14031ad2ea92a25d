// View depth of the scene from the host's depth image.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/host_depth.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer SceneWords { uint scene_words[]; };
layout(std430, binding = 2) writeonly buffer Scene { float scene[]; };
layout(push_constant) uniform SceneConstants {
    uint kind;  // UNORM_16, UNORM_24 or FLOATS
} constants;

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= params.size.x * params.size.y) {
        return;
    }
    uint word = scene_words[constants.kind == UNORM_16 ? pixel / 2u : pixel];
    uint half_word = (pixel & 1u) == 0u ? word & 0xffffu : word >> 16u;
    float depth = constants.kind == UNORM_16 ? float(half_word) / 65535.0
        : constants.kind == UNORM_24 ? float(word & 0xffffffu) / 16777215.0 : uintBitsToFloat(word);
    float z = view_depth(depth);
    // Nothing is there where the depth is beyond the projection's end.
    scene[pixel] = is_finite(z) && z > 0.0 ? z : uintBitsToFloat(INFINITY_BITS);
}
