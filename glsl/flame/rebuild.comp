// Which classes the table on the device lacks: all of them where the mask's level has changed, or the host says so.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 1) in;
layout(std430, binding = 1) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 2) buffer KernelState { KernelTable table; };
layout(push_constant) uniform RebuildConstants { uint force; } constants;
#include "mask_level.glsl"
#include "kernel.glsl"

void main() {
    uint level = max(mask_level(), 1u);
    uint known = constants.force != 0u || level != table.level ? 0u : table.classes;
    uint wanted = control.classes & ~known;
    table.level = level;
    table.classes = known | wanted;
    table.new_classes = wanted;
    uint side = MASK_SIDE >> level;
    table.share_groups = uvec4(wanted != 0u ? (KERNEL_CLASSES * side * side + KERNEL_LANES - 1u) / KERNEL_LANES : 0u, 1u, 1u, 0u);
    table.kernel_groups = uvec4(wanted != 0u ? (KERNEL_CLASSES * KERNEL_PLACES * KERNEL_PLACES + KERNEL_LANES - 1u) / KERNEL_LANES : 0u, 1u, 1u, 0u);
}
