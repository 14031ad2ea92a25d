// Which point of a part is the farthest in each direction: of several the first.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "directions.glsl"
layout(local_size_x = DIRECTIONS) in;
layout(std430, binding = 1) readonly buffer PartChunks { Chunk part_chunks[]; };
layout(std430, binding = 2) readonly buffer ChunkFarthest { uvec2 chunk_farthest[]; };
layout(std430, binding = 3) readonly buffer SupportValues { uint support_values[]; };
layout(std430, binding = 4) buffer SupportPoints { uint support_points[]; };

void main() {
    uvec2 own = chunk_farthest[gl_GlobalInvocationID.x];
    uint at = part_chunks[gl_WorkGroupID.x].part * DIRECTIONS + gl_LocalInvocationID.x;
    if (own.y != NONE && own.x == support_values[at]) {
        atomicMin(support_points[at], own.y);
    }
}
