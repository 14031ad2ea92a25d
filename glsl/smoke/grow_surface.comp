// Radius by the surface: the distance to where the trilinear density is no longer above the threshold (`excess.glsl`). The
// nearest such place is on the surface, which lies in the cells that the threshold crosses: of those, the ones nearer than
// the best so far are looked at, box by box. They are found in a pyramid of "any crossing" bits: rows (along x) in Morton
// order of (y, z), counted from the particle's own so that what is near comes first, blocks of rows passed over where they
// are too far or hold no crossing near enough.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/bits.glsl"
layout(local_size_x = 64) in;
#include "grow.glsl"
#include "voxel_words.glsl"
layout(push_constant) uniform SurfaceConstants {
    uint part;        // 0 begins, others go on
    uint parts;       // the last one ends
    uint iterations;  // of the loop in this dispatch
    uint is_ball;     // 1: Euclidean distance instead of the largest axis
    uint last;        // end of the cursor's range
} constants;
#include "search_part.glsl"
layout(std430, binding = 3) readonly buffer Density { float density[]; };
layout(std430, binding = 4) readonly buffer Crossings { uint crossings[]; };
#include "surface_box.glsl"
layout(std430, binding = 7) buffer SurfaceSearches { SurfaceSearch surface_searches[]; };

// Distance along an axis from p to cells first .. last.
float to_cells(vec3 p, int first, int last, int axis) {
    return max(0.0, max(voxel_centre(first - 1, axis) - p[axis], p[axis] - voxel_centre(last, axis)));
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

// Of the cells of a row that are crossed, from `left` down or from `right` up, the one nearest along x and how far that is:
// infinitely if there is none within `limit`.
int nearest_crossed(uint row, vec3 p, int left, int right, float limit, out float distance) {
    int found = NO_CELL;
    distance = INFINITY;
    uint mask = 0xffffffffu >> uint(31 - (left & 31));
    for (int w = left >> 5; w >= 0; --w) {
        uint bits = crossings[row + uint(w)] & mask;
        mask = 0xffffffffu;
        int cell = bits != 0u ? w * 32 + findMSB(bits) : w * 32;
        float at = to_cells(p, cell, cell, 0);
        found = bits != 0u && at <= limit ? cell : found;
        if (bits != 0u || at > limit) {
            distance = found == NO_CELL ? INFINITY : at;
            break;
        }
    }
    mask = 0xffffffffu << uint(right & 31);
    for (int w = right >> 5; w < int(params.crossing_row_words); ++w) {
        uint bits = crossings[row + uint(w)] & mask;
        mask = 0xffffffffu;
        int cell = bits != 0u ? w * 32 + findLSB(bits) : w * 32 + 31;
        float at = to_cells(p, cell, cell, 0);
        if (bits != 0u && at <= limit && at < distance) {
            found = cell;
            distance = at;
        }
        if (bits != 0u || at > limit) {
            break;
        }
    }
    return found;
}

uint first_word(uint level, ivec2 at) {
    PyramidLevel rows = params.levels[level];
    return rows.first_word + (uint(at.y) * rows.rows_y + uint(at.x)) * params.crossing_row_words;
}

void go_on(inout SurfaceSearch s, uint top) {
    s.cursor += 1u << 2u * s.level;
    s.level = min(top, uint(findLSB(s.cursor)) / 2u);
    s.left = s.right;
}

// (y, z) of the rows that the search stands at.
ivec2 rows_at(SurfaceSearch s, uint own) {
    uint code = s.cursor ^ own;
    return ivec2(even_bits(code) >> s.level, even_bits(code >> 1) >> s.level);
}

// Rows of cells, or the next cell of one row.
void look_at_rows(inout SurfaceSearch s, vec3 p, ivec3 cell, uint own, uint top) {
    ivec2 at = rows_at(s, own);
    PyramidLevel rows = params.levels[s.level];
    float limit = s.nearest - TOLERANCE * params.smallest_side;
    bool enter = at.x < int(rows.rows_y) && at.y < int(rows.rows_z);
    int left = s.left < s.right ? s.left : cell.x;
    int right = s.left < s.right ? s.right : cell.x + 1;
    int found = NO_CELL;
    if (enter) {
        ivec2 first = at << s.level;
        ivec2 last = min((at + 1 << s.level) - 1, ivec2(params.dimensions.yz));
        float dy = to_cells(p, first.x, last.x, 1);
        float dz = to_cells(p, first.y, last.y, 2);
        enter = combined(0.0, dy, dz) < limit;
        if (enter) {
            float dx;
            found = nearest_crossed(first_word(s.level, at), p, left, right, limit, dx);
            enter = combined(dx, dy, dz) < limit;
        }
    }
    if (!enter) {
        go_on(s, top);
    } else if (s.level > 0u) {
        s.level -= 1u;
    } else {
        s.left = found <= left ? found - 1 : left;
        s.right = found >= right ? found + 1 : right;
        s.cell = found;
        s.box_code = 0u;
        s.box_level = constants.is_ball != 0u ? BOX_LEVELS : 0u;
    }
}

// False if there is nothing to search.
bool resume(uint slot, vec3 p, ivec3 cell, uint top, out SurfaceSearch s) {
    if (constants.part > 0u) {
        s = surface_searches[slot];
        return s.cursor != FINISHED;
    }
    s = SurfaceSearch(0u, outside_distance(p, voxel_of(p)), top, 0, 0, NO_CELL, 0u, 0u, 0.0);
    bool within = all(greaterThanEqual(cell, ivec3(0))) && all(lessThanEqual(cell, ivec3(params.dimensions.xyz)));
    bool in_smoke = false;
    if (is_alive(slot) && within) {
        Place place = place_in(p, cell);
        in_smoke = excess_at(place.cell, clamp(place.at, 0.0, 1.0)) > 0.0;
    }
    if (!in_smoke) {
        if (is_alive(slot)) {
            put_sphere(slot, p, 0.0);
        } else {
            spheres[slot] = vec4(p, 0.0);
        }
        surface_searches[slot].cursor = FINISHED;
    }
    return in_smoke;
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= params.particles) {
        return;
    }
    vec3 p = position_of(slot);
    ivec3 cell = cell_of(p);
    uint top = min(uint(findMSB(constants.last)) / 2u, MAX_LEVELS - 1u);
    SurfaceSearch s;
    if (!resume(slot, p, cell, top, s)) {
        return;
    }
    uint own = to_even_bits(uint(cell.y)) | to_even_bits(uint(cell.z)) << 1;
    Place place;
    if (s.cell != NO_CELL) {
        place = place_in(p, ivec3(s.cell, rows_at(s, own)));
    }
    for (uint iteration = 0u; iteration < constants.iterations && s.cursor < constants.last; ++iteration) {
        if (s.cell == NO_CELL) {
            look_at_rows(s, p, cell, own, top);
            if (s.cell != NO_CELL) {
                place = place_in(p, ivec3(s.cell, rows_at(s, own)));
            }
        }
        if (s.cell != NO_CELL && constants.is_ball != 0u) {
            look_at_box(place, s);
        } else if (s.cell != NO_CELL) {
            grow_in_cell(place, s);
        }
    }
    bool ends = s.cursor >= constants.last || constants.part + 1u == constants.parts;
    if (ends) {
        s.cursor = FINISHED;
        put_sphere(slot, p, s.nearest);
    } else {
        ask_for_another();
    }
    surface_searches[slot] = s;
}
