// Radius by the surface: the distance to where the trilinear density is no longer above the threshold (`excess.glsl`). The
// nearest such place is on the surface, which lies in the cells that the threshold crosses. A workgroup searches for a particle:
// from the top of a pyramid of "any crossing" bits down, how far the farthest corner of a crossed cell can be at most; then, of
// the crossed cells that come nearer than what is known, how near the surface is. A box that had a radius in the
// last frame is begun with lower, with what is little farther away than that, and at the top only if nothing is there.
// Rows of cells, along x, are dealt out to the invocations. The radius does not depend on which of them comes first.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
layout(local_size_x = 8, local_size_y = 4) in;
#include "grow.glsl"
#include "voxel_words.glsl"
layout(constant_id = 0) const uint IS_BALL = 0u;  // 1: Euclidean distance instead of the largest axis
layout(push_constant) uniform SurfaceConstants { uint top; } constants;  // level that the search begins at
bool is_ball() {
    return IS_BALL != 0u;
}
#include "distance.glsl"
layout(std430, binding = 3) readonly buffer Density { float density[]; };
layout(std430, binding = 4) readonly buffer Crossings { uint crossings[]; };
#include "surface_box.glsl"

const int LEVELS_DOWN = 2;         // at once
const float MARGIN = 1e-3;         // of a side, for rounding: cells that are looked at beyond those that count
const float MOST_STEPS = 1e6;      // of a cell's diagonal
const uint CELLS_A_TURN = 12u;     // of an invocation's rows that are looked at with those of others
const uint SEARCHERS = gl_WorkGroupSize.x * gl_WorkGroupSize.y;
const ivec2 ROWS = ivec2(gl_WorkGroupSize.xy);  // along y and z, that they take together
const uint CELL_BITS = 16u;        // of a queued cell's number along y
const int NO_CELL = -1;
const float CHANGE = 2.0;          // of a radius between frames, in smallest sides: what is usual, and a cell's own size
const float LOW_SIDES = 4.0;       // a distance that level 0 is begun with, in smallest sides

shared uint farthest_bits;  // distance, as bits: no farthest corner of a crossed cell that was seen is nearer
shared uint nearest_bits;   // distance to the surface, as bits; in the chessboard norm steps that it is nearer than `farthest`
shared uint in_smoke;
shared uint queued;
shared uint goes_on;        // some rows have more cells
shared uint outer_bits;     // distance, as bits, that rows are within
shared uvec2 queue[CELLS_A_TURN * SEARCHERS];

// A search for a particle. Places are in sides, from the low corner of the first cell.
struct Search {
    vec3 p;
    vec3 at;
    vec3 sides;
    float farthest;  // than which the surface is not farther
    float step_;     // in the chessboard norm
};

// Along an axis, in sides, from a place to cells first .. last: to their near ends and to their far ones.
float to_cells(float at, int first, int last) {
    return max(0.0, max(float(first) - at, at - float(last + 1)));
}

float across_cells(float at, int first, int last) {
    return max(float(last + 1) - at, at - float(first));
}

ivec3 cell_of(vec3 p) {
    ivec3 voxel = voxel_of(p);
    for (int a = 0; a < 3; ++a) {
        voxel[a] += p[a] < voxel_centre(voxel[a], a) ? 0 : 1;
    }
    return voxel;
}

Place place_in(vec3 p, ivec3 cell) {
    vec3 low = vec3(voxel_centre(cell.x - 1, 0), voxel_centre(cell.y - 1, 1), voxel_centre(cell.z - 1, 2));
    return Place((p - low) / params.voxel_size.xyz, corners_of(cell));
}

// Cells along an axis that come as near as `distance`.
ivec2 cells_within(float at, float distance, uint last) {
    return ivec2(floor(clamp(vec2(at - distance, at + distance) + vec2(-MARGIN, MARGIN), 0.0, float(last))));
}

// The crossed cell of a row whose far end along x is nearest, and how far that is, if not farther than `limit`.
int nearest_crossed(uint row, float at, float limit, out float distance) {
    int x = int(at);
    int low = x >> 5;
    int high = low;
    uint here = crossings[row + uint(low)];
    uint left = here & (0xffffffffu >> uint(31 - (x & 31)));
    uint right = here & (0xffffffffu << uint(x & 31));
    while (left == 0u && low > 0 && at - float(low * 32 - 1) < limit) {
        low -= 1;
        left = crossings[row + uint(low)];
    }
    while (right == 0u && high < int(params.crossing_row_words) - 1 && float(high * 32 + 33) - at < limit) {
        high += 1;
        right = crossings[row + uint(high)];
    }
    ivec2 cells = ivec2(low * 32 + findMSB(left), high * 32 + findLSB(right));
    vec2 to = vec2(left != 0u ? across_cells(at, cells.x, cells.x) : INFINITY,
                   right != 0u ? across_cells(at, cells.y, cells.y) : INFINITY);
    distance = min(to.x, to.y);
    return isinf(distance) ? NO_CELL : to.x < to.y ? cells.x : cells.y;
}

// Lowers `farthest_bits` by what the rows of a level say. The cell of the own rows that says most, or NO_CELL along x.
ivec3 look_at_level(Search s, int level) {
    float limit = uintBitsToFloat(farthest_bits);
    barrier();
    ivec3 best = ivec3(NO_CELL);
    vec3 limits = limit / s.sides;
    ivec2 end = ivec2(params.dimensions.yz);
    PyramidLevel rows = params.levels[level];
    ivec2 y = cells_within(s.at.y, limits.y, params.dimensions.y) >> level;
    ivec2 z = cells_within(s.at.z, limits.z, params.dimensions.z) >> level;
    ivec2 lane = ivec2(gl_LocalInvocationID.xy);
    for (int row_z = z.x + lane.y; row_z <= z.y; row_z += ROWS.y) {
        float far_z = s.sides.z * across_cells(s.at.z, row_z << level, min((row_z + 1 << level) - 1, end.y));
        for (int row_y = y.x + lane.x; row_y <= y.y; row_y += ROWS.x) {
            float far_y = s.sides.y * across_cells(s.at.y, row_y << level, min((row_y + 1 << level) - 1, end.x));
            uint first = rows.first_word + (uint(row_z) * rows.rows_y + uint(row_y)) * params.crossing_row_words;
            float far_x;
            int cell = nearest_crossed(first, s.at.x, limits.x, far_x);
            float far = combined(s.sides.x * far_x, far_y, far_z);
            best = far < limit ? ivec3(cell, row_y, row_z) : best;
            limit = min(limit, far);
        }
    }
    atomicMin(farthest_bits, floatBitsToUint(limit));
    barrier();
    return best;
}

// Lowers `farthest_bits` to the least distance to a far corner of a crossed cell. The cell of the own rows that has it, or
// NO_CELL along x.
ivec3 crossed_cell(Search s) {
    uint begin = farthest_bits;
    int top = int(constants.top);
    uint sides = uint(min(uintBitsToFloat(begin) / (LOW_SIDES * params.smallest_side), 1e6));
    int level = min(findMSB(sides) + 1, top);
    ivec3 cell;
    while (level >= 0) {
        cell = look_at_level(s, level);
        level = level == 0 ? -1 : max(level - LEVELS_DOWN, 0);
        bool found_none = level < 0 && farthest_bits == begin && begin != INFINITY_BITS;
        barrier();
        if (found_none) {
            if (gl_LocalInvocationIndex == 0u) {
                farthest_bits = INFINITY_BITS;
            }
            begin = INFINITY_BITS;
            level = top;
        }
        barrier();
    }
    return cell;
}

// A first look into a crossed cell: in the chessboard norm the last, too.
void look_in(Search s, ivec3 cell) {
    Place place = place_in(s.p, cell);
    if (!is_ball()) {
        vec3 near = max(vec3(0.0), max(-place.at, place.at - 1.0));
        uint found = nearest_bits;
        uint most = uint(clamp((s.farthest - norm(s.sides * near)) / s.step_, 0.0, MOST_STEPS));
        atomicMax(nearest_bits, steps_in_cell(place, s.farthest, s.step_, most, found));
    } else {
        float best = s.farthest;
        narrow(place, vec3(0.0), 1.0, s.farthest - TOLERANCE * params.smallest_side, best);
        atomicMin(nearest_bits, floatBitsToUint(best));
    }
}

// What is known of the distance to the surface: it is not farther.
float known(Search s) {
    return is_ball() ? uintBitsToFloat(nearest_bits) : s.farthest - float(nearest_bits) * s.step_;
}

void queue_cell(ivec3 cell) {
    queue[atomicAdd(queued, 1u)] = uvec2(cell.x, cell.y | cell.z << CELL_BITS);
}

// Where an invocation stands in its rows.
struct Rows {
    ivec2 row;
    int word;
    int last_word;
    uint bits;  // of cells that are left in the word
    bool ended;
};

Rows before_rows(Search s) {
    float outer = uintBitsToFloat(outer_bits);
    int y = cells_within(s.at.y, outer / s.sides.y, params.dimensions.y).x;
    int z = cells_within(s.at.z, outer / s.sides.z, params.dimensions.z).x;
    return Rows(ivec2(y, z) + ivec2(gl_LocalInvocationID.xy) - ivec2(ROWS.x, 0), 0, 0, 0u, false);
}

// Queues crossed cells of the own rows whose near ends are nearer than `outer`, not more than are looked at in a turn. (None is
// wholly nearer than `farthest`, which is the least distance to a far corner.) One loop, whose iteration takes the next row, or
// the next word of it, and a cell.
void queue_cells(Search s, inout Rows r, float outer) {
    float widest = uintBitsToFloat(outer_bits);
    ivec2 y = cells_within(s.at.y, widest / s.sides.y, params.dimensions.y);
    int last_z = cells_within(s.at.z, widest / s.sides.z, params.dimensions.z).y;
    PyramidLevel rows = params.levels[0];
    uint cells = 0u;
    while (cells < CELLS_A_TURN && !r.ended) {
        bool next_row = r.bits == 0u && r.word >= r.last_word;
        r.word += r.bits == 0u ? 1 : 0;
        r.row.x += next_row ? ROWS.x : 0;
        r.row = r.row.x > y.y ? ivec2(y.x + int(gl_LocalInvocationID.x), r.row.y + ROWS.y) : r.row;
        if (r.row.y > last_z || r.row.x > y.y) {
            r.ended = true;
            break;
        }
        vec2 near = s.sides.yz * vec2(to_cells(s.at.y, r.row.x, r.row.x), to_cells(s.at.z, r.row.y, r.row.y));
        float reach = is_ball() ? sqrt(max(outer * outer - dot(near, near), 0.0)) : outer;
        ivec2 wanted = cells_within(s.at.x, reach / s.sides.x, params.dimensions.x);
        r.word = next_row ? wanted.x >> 5 : r.word;
        r.last_word = next_row ? wanted.y >> 5 : r.last_word;
        uint at = rows.first_word + (uint(r.row.y) * rows.rows_y + uint(r.row.x)) * params.crossing_row_words + uint(r.word);
        uint fresh = crossings[at] & voxel_bits(r.word * 32, wanted.x, wanted.y);
        r.bits = r.bits == 0u ? fresh : r.bits;
        if (r.bits != 0u) {
            queue_cell(ivec3(r.word * 32 + findLSB(r.bits), r.row));
            cells += 1u;
        }
        r.bits &= r.bits - 1u;
    }
}

ivec3 queued_cell(uint i) {
    uvec2 cell = queue[i];
    return ivec3(cell.x, cell.y & (1u << CELL_BITS) - 1u, cell.y >> CELL_BITS);
}

float radius_of(vec3 p) {
    Search s;
    s.p = p;
    s.sides = params.voxel_size.xyz;
    s.at = (p - vec3(voxel_centre(-1, 0), voxel_centre(-1, 1), voxel_centre(-1, 2))) / s.sides;
    ivec3 cell = crossed_cell(s);
    s.farthest = uintBitsToFloat(farthest_bits);
    float diagonal = combined(s.sides.x, s.sides.y, s.sides.z);
    s.step_ = max(TOLERANCE * params.smallest_side, diagonal / MOST_STEPS);
    bool is_first = gl_LocalInvocationIndex == 0u;
    if (is_first) {
        nearest_bits = is_ball() ? farthest_bits : 0u;
        queued = 0u;
        goes_on = 1u;
    }
    barrier();
    if (cell.x != NO_CELL) {
        queue_cell(cell);
    }
    // The first turn is of the cells that said most.
    Rows rows;
    for (bool is_first_turn = true, is_last = false; !is_last; is_first_turn = false) {
        barrier();
        is_last = goes_on == 0u;
        for (uint i = gl_LocalInvocationIndex; i < queued; i += SEARCHERS) {
            look_in(s, queued_cell(i));
        }
        barrier();
        float nearest = known(s);
        barrier();
        for (uint i = gl_LocalInvocationIndex; i < queued && is_ball(); i += SEARCHERS) {
            atomicMin(nearest_bits, floatBitsToUint(nearest_in_cell(place_in(p, queued_cell(i)), nearest)));
        }
        barrier();
        if (is_first) {
            queued = 0u;
            goes_on = 0u;
            outer_bits = is_first_turn ? floatBitsToUint(known(s)) : outer_bits;
        }
        barrier();
        if (is_first_turn) {
            rows = before_rows(s);
        }
        queue_cells(s, rows, known(s));
        atomicOr(goes_on, rows.ended ? 0u : 1u);
    }
    return known(s);
}

void main() {
    uint slot = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (slot >= params.particles) {
        return;
    }
    bool is_first = gl_LocalInvocationIndex == 0u;
    vec3 p = position_of(slot);
    ivec3 cell = cell_of(p);
    if (is_first) {
        bool within = all(greaterThanEqual(cell, ivec3(0))) && all(lessThanEqual(cell, ivec3(params.dimensions.xyz)));
        in_smoke = 0u;
        if (is_alive(slot) && within) {
            Place place = place_in(p, cell);
            in_smoke = excess_at(place.cell, clamp(place.at, 0.0, 1.0)) > 0.0 ? 1u : 0u;
        }
        // In the Euclidean norm what is found depends, within the tolerance, on what is known before.
        farthest_bits = !is_ball() && had_radius(slot) ? floatBitsToUint(radii[slot] + CHANGE * params.smallest_side) : INFINITY_BITS;
    }
    barrier();
    float radius = in_smoke != 0u ? radius_of(p) : 0.0;
    if (is_first && is_alive(slot)) {
        put_sphere(slot, p, radius);
    } else if (is_first) {
        spheres[slot] = vec4(p, 0.0);
    }
}
