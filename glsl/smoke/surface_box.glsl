// The surface in a cell: where the trilinear density is the threshold. In the Euclidean norm, a cell is halved along each axis,
// up to eight times; of its boxes, those that hold nothing nearer are passed over.
//
// In a box, the least and the most of what is trilinear are at corners, so the corners say whether it holds surface. How near
// that can be: the box itself; and with l the linear function through the corners' mean and mean slopes, the density minus l
// is trilinear too, so it is never below its least r at a corner, and no surface lies where l + r > 0. What lies beyond that
// plane is as far as the plane. In a box half as large r is a quarter, so boxes need not become small. A point where the
// density is found not above the threshold bounds the distance from above; a box that can only be nearer by less than
// TOLERANCE is passed over. A smallest box is as far as its farthest corner: off by at most its diagonal, sqrt(3) / 256 sides.
// So radii are too large by at most TOLERANCE of the smallest side, or that diagonal.
#include "excess.glsl"
#include "morton.glsl"

const float TOLERANCE = 0.015;    // of the smallest side of a voxel
const float OVERSHOOT = 0.125;    // of that, beyond where the surface is looked for
const uint BOX_LEVELS = 8u;       // halvings of a cell
const float LEAST_SIDE = 1e-6;    // of a box whose slopes are asked for, in sides of its cell
const int TRIES = 3;              // to find a place of the surface in a box
const float ROUNDING = 2e-6;      // of sums of a box's corners, in the largest of them

// Where the search of a radius stands.
struct SurfaceSearch {
    uint cursor;   // in Morton order of rows, counted from the particle's own
    float nearest;  // distance so far
    uint level;    // of rows that are looked at next
    int left;      // cells of the row from here on are to be looked at, to the left and to the right; none if these are equal
    int right;
    int cell;      // of the row, whose boxes are being looked at; or NO_CELL
    uint box_code;    // of the cell, in Morton order, counted from the one nearest to the particle
    uint box_level;  // 0 in the chessboard norm: nothing is known of the cell yet
    float clear;     // of the cell, in that norm: no surface is as near as this
};

const int NO_CELL = -1;

float norm(vec3 v) {
    return combined(abs(v.x), abs(v.y), abs(v.z));
}

float least_of(vec4 v) {
    return min(min(v.x, v.y), min(v.z, v.w));
}

// A function that is linear in space and about the density of a box: distances from where it is 0, in metres.
struct Plane {
    vec3 normal;     // of length 1, or 0
    float value;     // at the box's middle
    float residual;  // added to it, it is nowhere above the density
    float slope;     // of the density, per metre
};

Plane plane_of(Corners b, vec3 sides) {
    const vec4 ONE = vec4(1.0);
    const vec4 Y = vec4(-1.0, 1.0, -1.0, 1.0);
    const vec4 Z = vec4(-1.0, -1.0, 1.0, 1.0);
    float low = dot(b.low, ONE);
    float high = dot(b.high, ONE);
    vec4 both = b.low + b.high;
    vec3 slope = 0.25 * vec3(high - low, dot(both, Y), dot(both, Z));
    float middle = 0.125 * (low + high);
    vec4 across = middle + 0.5 * (slope.y * Y + slope.z * Z);
    float residual = min(least_of(b.low - (across - 0.5 * slope.x)), least_of(b.high - (across + 0.5 * slope.x)));
    vec4 largest = max(abs(b.low), abs(b.high));
    residual -= ROUNDING * max(max(largest.x, largest.y), max(largest.z, largest.w));
    vec3 size = abs(slope);
    float unit = max(size.x, max(size.y, size.z));
    if (unit == 0.0) {
        return Plane(vec3(0.0), 0.0, -INFINITY, 1.0);
    }
    vec3 normal = slope / unit / sides;
    float dual = length(normal);
    return Plane(normal / dual, middle / unit / dual, residual / unit / dual, unit * dual);
}

// The particle and the cell that it is searched in.
struct Place {
    vec3 at;       // the particle from the cell's low corner, in sides
    Corners cell;
};

// Whether a box may hold surface nearer than `best`, which what is found lowers.
bool narrow(Place place, vec3 corner, float side, inout float best) {
    vec3 low = corner;
    vec3 sides = params.voxel_size.xyz;
    float tolerance = TOLERANCE * params.smallest_side;
    float limit = best - tolerance;
    vec3 apart = max(vec3(0.0), max(low - place.at, place.at - (low + side))) * sides;
    float reach = norm(apart);
    if (reach >= limit) {
        return false;
    }
    // What lies nearer than the best is within a smaller box: along each axis as far as the others leave.
    vec3 squares = apart * apart;
    vec3 within = sqrt(max(limit * limit - squares.yzx - squares.zxy, 0.0)) / sides;
    vec3 high = min(low + side, place.at + within);
    low = max(low, place.at - within);
    vec3 nearest = clamp(place.at, low, high);
    Corners b = corners_within(place.cell, low, high);
    if (least_of(min(b.low, b.high)) > 0.0) {
        return false;
    }
    if (excess_at(place.cell, nearest) <= 0.0) {
        best = reach;
        return false;
    }
    Plane plane = plane_of(b, max(high - low, LEAST_SIDE) * sides);
    float value = plane.value + dot(plane.normal, (place.at - 0.5 * (low + high)) * sides);
    if (value + plane.residual >= limit) {
        return false;
    }
    // Straight to the plane where the density is about the threshold, and a little beyond; from there as far again as what
    // is left of it says.
    vec3 way = plane.normal / sides;
    vec3 tried = place.at;
    float left = max(value, 0.0);
    for (int i = 0; i < TRIES; ++i) {
        tried = clamp(tried - (left + OVERSHOOT * tolerance) * way, low, high);
        float excess = excess_at(place.cell, tried);
        if (excess <= 0.0) {
            best = min(best, norm((place.at - tried) * sides));
            break;
        }
        left = excess / plane.slope;
    }
    return true;
}

// In the chessboard norm, what a box around the particle has of the cell is a box, so its corners say whether it holds a place
// that is not above the threshold. A cell that holds none within the best so far is done at once, in others the box is halved
// and grown until it is known to TOLERANCE.
void grow_in_cell(Place place, inout SurfaceSearch s) {
    vec3 sides = params.voxel_size.xyz;
    float tolerance = TOLERANCE * params.smallest_side;
    bool is_first = s.box_level == 0u;
    float tried = is_first ? s.nearest - tolerance : 0.5 * (s.clear + s.nearest);
    Corners b = corners_within(place.cell, clamp(place.at - tried / sides, 0.0, 1.0),
                               clamp(place.at + tried / sides, 0.0, 1.0));
    bool holds = least_of(min(b.low, b.high)) <= 0.0;
    s.clear = is_first ? norm((place.at - clamp(place.at, 0.0, 1.0)) * sides) : s.clear;
    s.clear = holds ? s.clear : tried;
    s.nearest = holds ? tried : s.nearest;
    s.box_level = 1u;
    s.cell = s.nearest - s.clear <= 1.001 * tolerance ? NO_CELL : s.cell;
}

// One box; after the last, the cell is done.
void look_at_box(Place place, inout SurfaceSearch s) {
    const float FINEST = float(1u << BOX_LEVELS);
    uvec3 own = uvec3(min(clamp(place.at, 0.0, 1.0) * FINEST, FINEST - 1.0));
    uint code = s.box_code ^ (to_third_bits(own.x) | to_third_bits(own.y) << 1 | to_third_bits(own.z) << 2);
    uvec3 index = uvec3(third_bits(code), third_bits(code >> 1), third_bits(code >> 2)) >> s.box_level;
    float side = float(1u << s.box_level) / FINEST;
    vec3 low = vec3(index) * side;
    if (narrow(place, low, side, s.nearest)) {
        if (s.box_level > 0u) {
            s.box_level -= 1u;
            return;
        }
        vec3 farthest = max(abs(place.at - low), abs(place.at - (low + side)));
        s.nearest = min(s.nearest, norm(farthest * params.voxel_size.xyz));
    }
    s.box_code += 1u << 3u * s.box_level;
    s.box_level = min(BOX_LEVELS, uint(findLSB(s.box_code)) / 3u);
    s.cell = s.box_code >> 3u * BOX_LEVELS != 0u ? NO_CELL : s.cell;
}
