// What the host has drawn of a frame, before its mesh: what is behind that is hidden. A little farther away, because the
// depth may have the mesh itself, as the host has rounded it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "picture.glsl"
#include "depths.glsl"
#include "common/scene_words.glsl"
#include "common/fragment.glsl"
layout(push_constant) uniform OccluderConstants {
    vec2 terms;  // of the depth image
    uint kind;   // UNORM_16, UNORM_24 or FLOATS
} constants;
layout(location = 0) out uint seen;

void main() {
    float held = scene_word(constants.kind, index_of(ivec2(pixel_of(gl_FragCoord.xy, uvec2(0u), params.size))));
    bool is_reversed = constants.terms.y > 0.0 == (params.is_orthographic == 0u);
    // At the far plane is nothing.
    if (is_reversed ? held <= 0.0 : held >= 1.0) {
        discard;
    }
    float depth = view_depth(constants.terms, held);
    depth += SAME_DEPTH * (params.is_orthographic != 0u ? params.depth_unit : depth);
    float nearness = depth > 0.0 && depth < INFINITY ? nearness_of(depth) : 0.0;
    if (!(nearness > 0.0)) {
        discard;
    }
    gl_FragDepth = min(nearness, 1.0);
    seen = 0u;
}
