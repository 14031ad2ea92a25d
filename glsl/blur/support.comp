// The farthest point of each chunk of a part in each direction, and of all its chunks how far that is; sums of the chunk's
// velocities.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "velocity_sums.glsl"
#include "../common/bits.glsl"
layout(local_size_x = DIRECTIONS) in;
layout(std430, binding = 1) readonly buffer PartMembers { uint part_members[]; };
layout(std430, binding = 2) readonly buffer PartChunks { Chunk part_chunks[]; };
layout(std430, binding = 3) readonly buffer Motions { PointMotion motions[]; };
layout(std430, binding = 4) readonly buffer Labels { uint labels[]; };
layout(std430, binding = 5) writeonly buffer ChunkSums { vec4 chunk_sums[]; };
layout(std430, binding = 6) writeonly buffer ChunkFarthest { uvec2 chunk_farthest[]; };
layout(std430, binding = 7) buffer SupportValues { uint support_values[]; };

shared vec2 positions[DIRECTIONS];
shared uint points[DIRECTIONS];

void main() {
    Chunk chunk = part_chunks[gl_WorkGroupID.x];
    uint lane = gl_LocalInvocationID.x;
    uint row = chunk.begin + lane;
    uint point = row < chunk.end ? part_members[row] : NONE;
    point = point != NONE && labels[point] != 0u ? point : NONE;
    PointMotion motion = PointMotion(vec2(0.0), vec2(0.0));
    if (point != NONE) {
        motion = motions[point];
    }
    positions[lane] = motion.position;
    points[lane] = point;
    vec4 sum = sum_velocities(
        vec4(motion.velocity, length(motion.velocity), point != NONE ? 1.0 : 0.0), lane);
    if (lane == 0u) {
        chunk_sums[gl_WorkGroupID.x] = sum;
    }
    vec2 way = direction_at(lane);
    uvec2 farthest = uvec2(0u, NONE);
    for (uint i = 0u; i < chunk.end - chunk.begin; ++i) {
        uint value = ordered(dot(way, positions[i]));
        farthest = points[i] != NONE && value > farthest.x ? uvec2(value, points[i]) : farthest;
    }
    chunk_farthest[gl_WorkGroupID.x * DIRECTIONS + lane] = farthest;
    if (farthest.y != NONE) {
        atomicMax(support_values[chunk.part * DIRECTIONS + lane], farthest.x);
    }
}
