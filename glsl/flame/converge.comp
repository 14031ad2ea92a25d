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

shared uint is_open;

const float WORD = 4294967296.0;
const float ONE = 65535.0;

void main() {
    uint tile = active_tiles[gl_WorkGroupID.x];
    uvec2 corner = TILE * uvec2(tile % params.tiles.x, tile / params.tiles.x);
    float n = float(tile_repetitions[tile]) + 2.0;
    vec4 unit = vec4(vec3(uintBitsToFloat(control.brightest) * params.intensity), 1.0);
    if (gl_LocalInvocationID.x == 0u) {
        is_open = 0u;
    }
    barrier();
    for (uint i = gl_LocalInvocationID.x; i < TILE * TILE; i += 64u) {
        uvec2 pixel = corner + uvec2(i % TILE, i / TILE);
        if (all(lessThan(pixel, params.size))) {
            uint at = 4u * (pixel.y * params.size.x + pixel.x);
            uvec4 low = sums[at];
            float hits = float(low.w);
            vec3 sum = (vec3(low.xyz) + WORD * vec3(sums[at + 1u].xyz)) / ONE;
            vec3 squares = (vec3(sums[at + 2u].xyz) + WORD * vec3(sums[at + 3u].xyz)) / (ONE * ONE);
            vec4 mean = (vec4(sum, hits) + 1.0) / n;
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
