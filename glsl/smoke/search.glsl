// What the searches of the nearest empty voxel share. A search may be cut at the loop budget (lavapipe ends an
// invocation's loops after 65,535 iterations): its state stays in memory and the next dispatch goes on.
#include "grow.glsl"
layout(std430, binding = 3) readonly buffer Occupancy { uint occupancy[]; };

// Where the search of a particle's radius stands.
struct Search {
    uint cursor;
    float nearest;  // distance so far
};

layout(std430, binding = 4) buffer Searches { Search searches[]; };
layout(push_constant) uniform SearchConstants {
    uint part;        // 0 begins, others go on
    uint iterations;  // of the outer loop in this dispatch
    uint is_ball;     // 1: Euclidean distance instead of the largest axis
    uint last;        // end of the cursor's range
} constants;

#include "occupancy.glsl"
layout(std430, binding = 5) buffer Continuations { uvec4 continuations[]; };  // dispatches that go on

const uint FINISHED = 0xffffffffu;  // instead of a cursor

bool is_ball() {
    return constants.is_ball != 0u;
}
#include "distance.glsl"

float along(vec3 p, int index, int axis) {
    return abs(p[axis] - voxel_centre(index, axis));
}

// The nearest voxel outside of the volume lies straight across one of its faces.
float outside_distance(vec3 p, ivec3 voxel) {
    vec3 own = vec3(along(p, voxel.x, 0), along(p, voxel.y, 1), along(p, voxel.z, 2));
    vec3 out_ = vec3(min(along(p, -1, 0), along(p, int(params.dimensions.x), 0)),
                     min(along(p, -1, 1), along(p, int(params.dimensions.y), 1)),
                     min(along(p, -1, 2), along(p, int(params.dimensions.z), 2)));
    return min(combined(out_.x, own.y, own.z), min(combined(own.x, out_.y, own.z), combined(own.x, own.y, out_.z)));
}

void ask_for_another() {
    uvec3 groups = constants.part == 0u ? gl_NumWorkGroups : continuations[constants.part - 1u].xyz;
    atomicMax(continuations[constants.part].x, groups.x);
    atomicMax(continuations[constants.part].y, 1u);
    atomicMax(continuations[constants.part].z, 1u);
}

// Words of a row of the pyramid with a 1 for each empty voxel; beyond the volume's end nothing is found.
uint empties(uint row, int word, uint level) {
    uint bits = ~occupancy[row + uint(word)];
    uint used = params.dimensions.x - uint(word) * WORD_VOXELS;
    return level == 0u && used < WORD_VOXELS ? bits & ((1u << used) - 1u) : bits;
}

// Distance along x from p to the nearest empty voxel of a row, infinite if there is none within `limit`.
float nearest_in_row(uint row, uint level, vec3 p, int x, float limit) {
    int word = x / 32;
    uint here = empties(row, word, level);
    uint left = here & (0xffffffffu >> uint(31 - x % 32));
    uint right = here & (0xffffffffu << uint(x % 32));
    float best = INFINITY;
    for (int w = word;;) {
        if (left != 0u) {
            best = along(p, w * 32 + findMSB(left), 0);
            break;
        }
        if (--w < 0 || along(p, w * 32 + 31, 0) > limit) {
            break;
        }
        left = empties(row, w, level);
    }
    for (int w = word;;) {
        if (right != 0u) {
            best = min(best, along(p, w * 32 + findLSB(right), 0));
            break;
        }
        if (++w >= int(params.row_words) || along(p, w * 32, 0) > min(limit, best)) {
            break;
        }
        right = empties(row, w, level);
    }
    return best;
}

// Where a slot's search stands; a new one starts with what lies outside. False if there is nothing to search.
bool resume_search(uint slot, vec3 p, ivec3 voxel, out uint cursor, out float best) {
    if (constants.part > 0u) {
        cursor = searches[slot].cursor;
        best = searches[slot].nearest;
        return cursor != FINISHED;
    }
    cursor = 0u;
    best = 0.0;
    if (!is_alive(slot) || !is_occupied(voxel)) {
        spheres[slot] = vec4(p, 0.0);
        searches[slot] = Search(FINISHED, 0.0);
        return false;
    }
    best = outside_distance(p, voxel);
    return true;
}

void keep_search(uint slot, vec3 p, uint cursor, float best) {
    bool finished = cursor >= constants.last;
    searches[slot] = Search(finished ? FINISHED : cursor, best);
    if (finished) {
        put_sphere(slot, p, best);
    } else {
        ask_for_another();
    }
}
