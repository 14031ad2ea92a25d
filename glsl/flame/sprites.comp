// The list of all render particles of a repetition: what the paper's way draws.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) buffer ControlBuffer { Control control; };
layout(std430, binding = 3) writeonly buffer SpriteList { uvec2 sprite_list[]; };
layout(std430, binding = 4) readonly buffer SpriteSums { uint block_sums[]; };
#define SCAN_TYPE uint
#define SCAN_BLOCKS
#include "common/scan.glsl"

void main() {
    uint row = gl_GlobalInvocationID.x;
    uint count = row < params.particle_count ? particles[row].count : 0u;
    Scan blocks = scan_blocks(gl_WorkGroupID.x, gl_NumWorkGroups.x);
    uint at = blocks.before + scan_workgroup(count).before;
    for (uint k = 0u; k < count; ++k) {
        sprite_list[at + k] = uvec2(row, k);
    }
    if (gl_GlobalInvocationID.x == 0u) {
        control.sprite_draw = uvec4(QUAD_VERTICES, blocks.all, 0u, 0u);
    }
}
