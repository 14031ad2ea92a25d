// Whether a tile needs more repetitions: the widest 95 % interval of its pixels. Two repetitions that never were, one black and one
// white, keep a pixel open that has not been hit yet.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 2) readonly buffer ActiveTiles { uint active_tiles[]; };
layout(std430, binding = 3) readonly buffer Sums { uvec4 sums[]; };
layout(std430, binding = 4) readonly buffer TileRepetitions { uint tile_repetitions[]; };
layout(std430, binding = 5) writeonly buffer TileOpen { uint tile_open[]; };
#include "sums.glsl"

shared uint is_open;

void main() {
    uint tile = active_tiles[gl_WorkGroupID.x];
    uvec2 corner = TILE * tile_at(tile);
    float n = float(tile_repetitions[tile]) + 2.0;
    vec4 unit = vec4(vec3(uintBitsToFloat(control.brightest) * params.intensity), 1.0);
    if (gl_LocalInvocationID.x == 0u) {
        is_open = 0u;
    }
    barrier();
    for (uint i = gl_LocalInvocationID.x; i < TILE * TILE; i += gl_WorkGroupSize.x) {
        uvec2 pixel = corner + uvec2(i % TILE, i / TILE);
        if (all(lessThan(pixel, params.size))) {
            Sum sum = load_sum(pixel_index(pixel));
            float hits = float(sum.hits);
            vec3 colours = (vec3(sum.low) + WORD * vec3(sum.high)) / LIGHT_STEPS;
            vec3 squares = (vec3(sum.square_low) + WORD * vec3(sum.square_high)) / (LIGHT_STEPS * LIGHT_STEPS);
            vec4 mean = (vec4(colours, hits) + 1.0) / n;
            vec4 variance = max((vec4(squares, hits) + 1.0) / n - mean * mean, 0.0);
            vec4 interval = 1.96 * unit * sqrt(variance / n);
            float widest = max(max(interval.x, interval.y), max(interval.z, interval.w));
            if (widest >= params.adaptive) {
                atomicOr(is_open, 1u);
            }
        }
    }
    barrier();
    if (gl_LocalInvocationID.x == 0u) {
        tile_open[tile] = is_open;
    }
}
