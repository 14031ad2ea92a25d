// The share of each of the mask's texels that passes the threshold of each class, over all variants. The values below a texel are sorted: a
// binary search finds how many pass.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "kernel.glsl"
layout(local_size_x = KERNEL_LANES) in;
layout(binding = 1, r32f) uniform readonly image2D levels;
layout(std430, binding = 2) readonly buffer KernelState { KernelTable table; };
layout(std430, binding = 3) writeonly buffer Shares { float shares[]; };
#include "pass_count.glsl"

void main() {
    uint level = table.level;
    uint side = MASK_SIDE >> level;
    uint texel = gl_GlobalInvocationID.x % (side * side);
    uint class_index = gl_GlobalInvocationID.x / (side * side);
    if (class_index >= KERNEL_CLASSES || !has_class(table.new_classes, class_index)) {
        return;
    }
    uint passing = 0u;
    for (uint variant = 0u; variant < params.variants; ++variant) {
        passing += pass_count(level, uvec2(texel % side, texel / side), variant, class_threshold(class_index));
    }
    shares[gl_GlobalInvocationID.x] = float(passing) / float(params.variants << (2u * level));
}
