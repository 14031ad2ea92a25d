// How high each pixel stands before what is beside it, and where that is ink: of the second differences of depth along
// the row, the column and both diagonals the largest. On the farther side of a step they are negative, and on slopes 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "screen.glsl"
#include "outline_depth.glsl"
#include "lines.glsl"
layout(local_size_x = TILE, local_size_y = 8) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 3) writeonly buffer Lines { float lines[]; };
layout(std430, binding = 4) buffer InkBits { uint ink_bits[]; };
#include "ink_bits.glsl"

shared uint weak[TILE];
shared uint strong[TILE];

float step_at(ivec2 at) {
    float centre = depth_at(at);
    if (centre == INFINITY) {
        return 0.0;
    }
    float highest = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 way = i == 0 ? ivec2(1, 0) : i == 1 ? ivec2(0, 1) : ivec2(1, i == 2 ? 1 : -1);
        float a = depth_at(at - way);
        float b = depth_at(at + way);
        if (a == INFINITY || b == INFINITY) {
            return SILHOUETTE;
        }
        highest = max(highest, (a - centre) + (b - centre));
    }
    return highest * per_unit_at(centre) * params.inner_strength;
}

void main() {
    uint tile = occupied_tiles[gl_WorkGroupID.x];
    uint lane = gl_LocalInvocationIndex;
    if (lane < TILE) {
        weak[lane] = 0u;
        strong[lane] = 0u;
    }
    barrier();
    for (uint row = gl_LocalInvocationID.y; row < TILE; row += gl_WorkGroupSize.y) {
        uvec2 at = tile_at(tile) * TILE + uvec2(gl_LocalInvocationID.x, row);
        if (is_in_picture(at)) {
            float high = step_at(ivec2(at));
            bool is_weak = high == SILHOUETTE || high > LOWEST_STEP;
            lines[pixel_index(at)] = is_weak ? high : 0.0;
            uint bit = 1u << gl_LocalInvocationID.x;
            if (is_weak) {
                atomicOr(weak[row], bit);
            }
            if (high == SILHOUETTE || high > LINE_STEP) {
                atomicOr(strong[row], bit);
            }
        }
    }
    barrier();
    if (lane < TILE) {
        ink_bits[INK_WORDS * tile + TILE * WEAK + lane] = weak[lane];
        ink_bits[INK_WORDS * tile + TILE * STRONG + lane] = strong[lane];
    }
}
