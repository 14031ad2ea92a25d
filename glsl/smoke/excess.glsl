// Density above the threshold between voxel centres, trilinear. Outside of the volume, and where a density is no number,
// there is none: 0, or the threshold where that is lower, so that this is never above it. What is beyond +-1e30 counts as
// that much, so that no sum overflows.
const float LARGEST_EXCESS = 1e30;

float excess_of(ivec3 v) {
    float empty = min(0.0, params.threshold);
    float value = empty;
    if (is_inside(v)) {
        value = density[row_of(uint(v.y), uint(v.z)) * params.dimensions.x + uint(v.x)];
        bool is_number = (floatBitsToUint(value) & ~SIGN_BIT) <= INFINITY_BITS;
        value = is_number ? value : empty;
    }
    return clamp(value - params.threshold, -LARGEST_EXCESS, LARGEST_EXCESS);
}

// Of the eight corners of a cell or of a box in it: those at the low and at the high end along x; (y, z) low and low, high
// and low, low and high, high and high.
struct Corners {
    vec4 low;
    vec4 high;
};

// Of a cell, by the voxel at its high end.
Corners corners_of(ivec3 cell) {
    return Corners(vec4(excess_of(cell - ivec3(1, 1, 1)), excess_of(cell - ivec3(1, 0, 1)),
                        excess_of(cell - ivec3(1, 1, 0)), excess_of(cell - ivec3(1, 0, 0))),
                   vec4(excess_of(cell - ivec3(0, 1, 1)), excess_of(cell - ivec3(0, 0, 1)),
                        excess_of(cell - ivec3(0, 1, 0)), excess_of(cell)));
}

// Exactly a at 0 and b at 1, however large the other one is.
vec4 between(vec4 a, vec4 b, float t) {
    precise vec4 sum = a * (1.0 - t) + b * t;
    return sum;
}

vec2 between(vec2 a, vec2 b, float t) {
    precise vec2 sum = a * (1.0 - t) + b * t;
    return sum;
}

float between(float a, float b, float t) {
    precise float sum = a * (1.0 - t) + b * t;
    return sum;
}

// At a place in the cell, 0 to 1 along each axis.
float excess_at(Corners c, vec3 t) {
    vec4 x = between(c.low, c.high, t.x);
    vec2 xy = between(x.xz, x.yw, t.y);
    return between(xy.x, xy.y, t.z);
}

// At four corners of a box in the cell that have the same x.
vec4 excess_across(vec4 x, vec2 low, vec2 high) {
    vec2 y0 = between(x.xz, x.yw, low.x);
    vec2 y1 = between(x.xz, x.yw, high.x);
    return vec4(between(y0.x, y0.y, low.y), between(y1.x, y1.y, low.y), between(y0.x, y0.y, high.y),
                between(y1.x, y1.y, high.y));
}

Corners corners_within(Corners c, vec3 low, vec3 high) {
    return Corners(excess_across(between(c.low, c.high, low.x), low.yz, high.yz),
                   excess_across(between(c.low, c.high, high.x), low.yz, high.yz));
}
