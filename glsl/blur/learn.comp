// Which colours the frames show of objects, by their world normal; once these are known, how much of what departs from them
// is the same in both frames; and then, how good predictions from it are where both frames show a place.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "samples.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
#include "seeing.glsl"
layout(std430, binding = 18) readonly buffer CornerGroups { uvec4 corner_groups[]; };
layout(std430, binding = 19) readonly buffer Normals { vec4 normals[]; };
layout(std430, binding = 20) readonly buffer Tables { uvec4 tables[]; };
layout(std430, binding = 21) buffer Sums { uint sums[]; };
layout(std430, binding = 22) buffer Completing { uint completing[]; };
layout(constant_id = 0) const uint GROUPS = 0;
layout(constant_id = 1) const uint STAGE = 0;  // 0: colours, 1: departures, 2: errors
#include "tables.glsl"

// Of the first lane's table, bins and object, which most lanes share: pixels and channels, for both kinds; or products.
shared uint usual[3];
shared uint gathered[2][5];
shared uint departed[4];

// Adds to a sum of 64 bits.
void add(uint low, uint high, bool is_shared, uint at) {
    if (is_shared) {
        uint before = atomicAdd(departed[at], low);
        atomicAdd(departed[at + 1u], high + (before + low < before ? 1u : 0u));
    } else {
        uint before = atomicAdd(completing[at], low);
        atomicAdd(completing[at + 1u], high + (before + low < before ? 1u : 0u));
    }
}

void add_channel(uint at, uint value) {
    uint before = atomicAdd(sums[at], value);
    if (before + value < before) {
        atomicAdd(sums[at + 4u * BINS], 1u);
    }
}

// Fields of a bin stand so far from one another that neighbouring bins are neighbours: pixels, low words, high words.
uint field_of(uint table, uint bin) {
    return table * 9u + bin;
}

void count(uint kind, uint table, uint bin, uvec4 units, bool is_usual) {
    if (is_usual) {
        atomicAdd(gathered[kind][0], 1u);
        for (uint i = 0u; i < 4u; ++i) {
            atomicAdd(gathered[kind][1u + i], units[i]);
        }
        return;
    }
    uint at = field_of(table, bin);
    atomicAdd(sums[at], 1u);
    for (uint i = 0u; i < 4u; ++i) {
        add_channel(at + (1u + i) * BINS, units[i]);
    }
}

bool is_same(uint frame, ivec2 at, uint object) {
    if (!is_in_picture(at)) {
        return true;
    }
    uint seen = seen_at(frame, at);
    return seen > 0u && triangles[seen - 1u].w >> 1 == object;
}

// Where the sums of this stage begin.
uint kept_of(uint object, uint frame) {
    uint at = products_of(object, frame);
    if (STAGE == 2u) {
        at += 4u;
    }
    return at;
}

struct Lesson {
    uint object;
    uvec2 bins;       // in this frame and in the other
    uvec4 units[2];   // colours there
};

// What a pixel teaches: nothing, if it and its neighbours do not all see one object.
Lesson lesson_of(uint frame, ivec2 at) {
    Lesson lesson = Lesson(0u, uvec2(NO_BIN), uvec4[2](uvec4(0u), uvec4(0u)));
    uint seen = is_in_picture(at) ? seen_at(frame + 1u, at) : 0u;
    if (seen == 0u) {
        return lesson;
    }
    uvec4 base = triangles[seen - 1u];
    lesson.object = base.w >> 1;
    bool is_inner = is_same(frame + 1u, at - ivec2(1, 0), lesson.object) && is_same(frame + 1u, at + ivec2(1, 0), lesson.object)
        && is_same(frame + 1u, at - ivec2(0, 1), lesson.object) && is_same(frame + 1u, at + ivec2(0, 1), lesson.object);
    // What may be an outline says nothing of a surface.
    is_inner = is_inner && (cover_at(at) & OUTLINE << (frame + 1u)) == 0u;
    vec3 edges = edges_at(corner_of(frame + 1u, base.x), corner_of(frame + 1u, base.y), corner_of(frame + 1u, base.z), vec2(at) + 0.5);
    float sum = edges.x + edges.y + edges.z;
    if (!is_inner || lesson.object >= params.completion.x || !(sum != 0.0)) {
        return lesson;
    }
    vec3 shares = edges / sum;
    lesson.bins.x = bin_of(normal_at(frame, seen - 1u, base, shares));
    lesson.units[0] = quantised(colour_at(frame + 1u, at), scale_of_images());
    vec4 colour;
    float weight;
    look(2u - frame, base, shares, colour, weight);
    if (lesson.bins.x != NO_BIN && weight > LEAST_WEIGHT) {
        lesson.bins.y = bin_of(normal_at(1u - frame, seen - 1u, base, shares));
        lesson.units[1] = quantised(colour, scale_of_images());
    }
    return lesson;
}

// The product of two numbers of 17 bits, as 64 bits.
void multiply(int a, int b, bool is_shared, uint at) {
    int high;
    int low;
    imulExtended(a, b, high, low);
    add(uint(low), uint(high), is_shared, at);
}

void main() {
    ivec2 at = ivec2(tile_origin() + gl_LocalInvocationID.xy);
    uint frame = gl_GlobalInvocationID.z;
    uint lane = gl_LocalInvocationIndex;
    Lesson lesson = lesson_of(frame, at);
    if (lane < 10u) {
        gathered[lane / 5u][lane % 5u] = 0u;
    }
    if (lane < 4u) {
        departed[lane] = 0u;
    }
    if (lane == 0u) {
        usual = uint[3](lesson.object, lesson.bins.x, lesson.bins.y);
    }
    barrier();
    bool is_usual = lesson.object == usual[0];
    if (STAGE == 0u) {
        for (uint kind = 0u; kind < 2u; ++kind) {
            if (lesson.bins[kind] != NO_BIN) {
                bool is_shared = is_usual && lesson.bins[kind] == usual[1u + kind];
                count(kind, table_of(lesson.object, frame, kind), lesson.bins[kind], lesson.units[kind], is_shared);
            }
        }
    } else if (lesson.bins.y != NO_BIN) {
        uvec4 own = tables[table_of(lesson.object, frame, 0u) + lesson.bins.x];
        uvec4 other = tables[table_of(lesson.object, frame, 1u) + lesson.bins.y];
        for (uint i = 0u; i < 3u && own.x != NO_COLOUR && other.x != NO_COLOUR; ++i) {
            int d = int(lesson.units[0][i]) - int(own[i]);
            int e = int(lesson.units[1][i]) - int(other[i]);
            uint to = is_usual ? 0u : kept_of(lesson.object, frame);
            if (STAGE == 2u) {
                int share = share_of(lesson.object, frame);
                add(uint(abs(d - (share * e + 128 >> 8))), 0u, is_usual, to);
                add(uint(abs(int(lesson.units[0][i]) - int(lesson.units[1][i]))), 0u, is_usual, to + 2u);
            } else {
                multiply(d, e, is_usual, to);
                multiply(e, e, is_usual, to + 2u);
            }
        }
    }
    barrier();
    if (STAGE == 0u && lane < 10u) {
        uint kind = lane / 5u;
        uint channel = lane % 5u;
        if (gathered[kind][channel] > 0u) {
            uint to = field_of(table_of(usual[0], frame, kind), usual[1u + kind]) + channel * BINS;
            if (channel == 0u) {
                atomicAdd(sums[to], gathered[kind][channel]);
            } else {
                add_channel(to, gathered[kind][channel]);
            }
        }
    }
    if (STAGE != 0u && lane < 2u && (departed[2u * lane] | departed[2u * lane + 1u]) != 0u) {
        uint to = kept_of(usual[0], frame) + 2u * lane;
        add(departed[2u * lane], departed[2u * lane + 1u], false, to);
    }
}
