// The surface in a cell: where the trilinear density is the threshold. What a cell says does not depend on what others have
// said, so that cells can be looked at in any order and at once; what others have said only tells which need not be.
//
// In the Euclidean norm, a cell is halved along each axis, up to eight times; of its boxes, those that hold nothing nearer are
// passed over. In a box, the least and the most of what is trilinear are at corners, so the corners say whether it holds
// surface. How near that can be: the box itself; and with l the linear function through the corners' mean and mean slopes, the
// density minus l is trilinear too, so it is never below its least r at a corner, and no surface lies where l + r > 0. What
// lies beyond that plane is as far as the plane. In a box half as large r is a quarter, so boxes need not become small. A point
// where the density is found not above the threshold bounds the distance from above; a box that can only be nearer by less
// than TOLERANCE is passed over. A smallest box is as far as its farthest corner: off by at most its diagonal, sqrt(3) / 256
// sides. So radii are too large by at most TOLERANCE of the smallest side, or that diagonal.
#include "excess.glsl"
#include "morton.glsl"

const float TOLERANCE = 0.015;    // of the smallest side of a voxel
const float OVERSHOOT = 0.125;    // of that, beyond where the surface is looked for
const uint BOX_LEVELS = 8u;       // halvings of a cell
const float LEAST_SIDE = 1e-6;    // of a box whose slopes are asked for, in sides of its cell
const int TRIES = 3;              // to find a place of the surface in a box
const uint MOST_BOXES = 4096u;    // of a cell that are looked at; one that needs more says the nearest found so far
const float ROUNDING = 2e-6;      // of sums of a box's corners, in the largest of them

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

// Whether a box may hold surface nearer than `limit`; what is found lowers `best`.
bool narrow(Place place, vec3 corner, float side, float limit, inout float best) {
    vec3 low = corner;
    vec3 sides = params.voxel_size.xyz;
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
        best = min(best, reach);
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
        tried = clamp(tried - (left + OVERSHOOT * TOLERANCE * params.smallest_side) * way, low, high);
        float excess = excess_at(place.cell, tried);
        if (excess <= 0.0) {
            best = min(best, norm((place.at - tried) * sides));
            break;
        }
        left = excess / plane.slope;
    }
    return true;
}

// How near the surface in a cell is, if it is nearer than `farthest`; in the Euclidean norm.
float nearest_in_cell(Place place, float farthest) {
    const float FINEST = float(1u << BOX_LEVELS);
    uvec3 own = uvec3(min(clamp(place.at, 0.0, 1.0) * FINEST, FINEST - 1.0));
    uint nearest_box = to_third_bits(own.x) | to_third_bits(own.y) << 1 | to_third_bits(own.z) << 2;
    float best = farthest;
    uint code = 0u;  // in Morton order, counted from the box nearest to the particle
    uint level = BOX_LEVELS;
    for (uint box_ = 0u; box_ < MOST_BOXES && code >> 3u * BOX_LEVELS == 0u; ++box_) {
        uint at = code ^ nearest_box;
        uvec3 index = uvec3(third_bits(at), third_bits(at >> 1), third_bits(at >> 2)) >> level;
        float side = float(1u << level) / FINEST;
        vec3 low = vec3(index) * side;
        bool holds = narrow(place, low, side, best - TOLERANCE * params.smallest_side, best);
        if (holds && level > 0u) {
            level -= 1u;
            continue;
        }
        vec3 farthest_corner = max(abs(place.at - low), abs(place.at - (low + side))) * params.voxel_size.xyz;
        best = min(best, holds ? norm(farthest_corner) : INFINITY);
        code += 1u << 3u * level;
        level = min(BOX_LEVELS, uint(findLSB(code)) / 3u);
    }
    return best;
}

// The least density of a cell within a distance of the particle, in the chessboard norm: what a box around the particle has of
// the cell is a box, so it is at a corner.
float least_within(Place place, float distance, out float largest) {
    vec3 reach = distance / params.voxel_size.xyz;
    Corners b = corners_within(place.cell, clamp(place.at - reach, 0.0, 1.0), clamp(place.at + reach, 0.0, 1.0));
    vec4 sizes = max(abs(b.low), abs(b.high));
    largest = max(max(sizes.x, sizes.y), max(sizes.z, sizes.w));
    return least_of(min(b.low, b.high));
}

// In that norm, how many STEPs nearer than `farthest` the cell holds surface, at most `most`. `found`: so many are known of
// others.
uint steps_in_cell(Place place, float farthest, float step_, uint most, uint found) {
    float largest;
    if (most <= found || least_within(place, farthest - float(found + 1u) * step_, largest) > ROUNDING * largest) {
        return 0u;
    }
    uint low = 0u;
    uint high = most;
    while (low < high) {
        uint middle = (low + high + 1u) / 2u;
        bool holds = least_within(place, farthest - float(middle) * step_, largest) <= 0.0;
        low = holds ? middle : low;
        high = holds ? high : middle - 1u;
    }
    return low;
}
