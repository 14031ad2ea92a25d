// Which colours the frames show of surfaces, by their world normal.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "samples.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
#include "seeing.glsl"
layout(std430, binding = 18) readonly buffer CornerGroups { uvec4 corner_groups[]; };
layout(std430, binding = 19) readonly buffer Normals { vec4 normals[]; };
layout(std430, binding = 20) buffer Sums { uint sums[]; };
layout(std430, binding = 21) readonly buffer Completing { uint completing[]; };
layout(constant_id = 0) const uint GROUPS = 0;
#include "tables.glsl"
#include "lesson.glsl"

// The first lane's surface and bin, which most lanes share: pixels and channels.
shared uint usual[2];
shared uint gathered[5];

void add_channel(uint at, uint value) {
    uint before = atomicAdd(sums[at], value);
    if (before + value < before) {
        atomicAdd(sums[at + 4u * BINS], 1u);
    }
}

void main() {
    ivec2 at = ivec2(tile_origin(gl_WorkGroupID) + gl_LocalInvocationID.xy);
    uint frame = gl_GlobalInvocationID.z;
    uint lane = gl_LocalInvocationIndex;
    Lesson lesson = lesson_of(1u + frame, at);
    uint surface = surface_of(lesson.base.w);
    bool is_told = lesson.is_there && surface < params.tables;
    uint bin = is_told ? bin_of(normal_at(frame, lesson.place, lesson.base, lesson.barycentrics)) : NONE;
    if (lane < 5u) {
        gathered[lane] = 0u;
    }
    if (lane == 0u) {
        usual = uint[2](surface, bin);
    }
    barrier();
    if (bin != NONE) {
        uvec4 units = quantised(colour_at(1u + frame, at), scale_of_images());
        // Fields of a bin stand so far from one another that neighbouring bins are neighbours: pixels, low words, high
        // words.
        uint to = table_of(surface, frame) * BIN_FIELDS + bin;
        bool is_usual = surface == usual[0] && bin == usual[1];
        if (is_usual) {
            atomicAdd(gathered[0], 1u);
        } else {
            atomicAdd(sums[to], 1u);
        }
        for (uint i = 0u; i < 4u; ++i) {
            if (is_usual) {
                atomicAdd(gathered[1u + i], units[i]);
            } else {
                add_channel(to + (1u + i) * BINS, units[i]);
            }
        }
    }
    barrier();
    if (lane < 5u && gathered[lane] > 0u) {
        uint to = table_of(usual[0], frame) * BIN_FIELDS + usual[1] + lane * BINS;
        if (lane == 0u) {
            atomicAdd(sums[to], gathered[0]);
        } else {
            add_channel(to, gathered[lane]);
        }
    }
}
