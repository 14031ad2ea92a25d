// View depth of the scene from the host's depth image.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/scene_words.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 2) writeonly buffer Scene { float scene[]; };
layout(push_constant) uniform SceneConstants {
    uint kind;  // UNORM_16, UNORM_24 or FLOATS
} constants;

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= params.size.x * params.size.y) {
        return;
    }
    float z = view_depth(params.depth_terms, scene_word(constants.kind, pixel));
    // Nothing is there where the depth is beyond the projection's end.
    scene[pixel] = is_finite(z) && z > 0.0 ? z : uintBitsToFloat(INFINITY_BITS);
}
