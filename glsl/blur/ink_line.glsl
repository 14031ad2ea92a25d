// Ink of meshes: where it is, at four samples a pixel, from differences of depth in units of eight samples' footprints. A line is
// also where another object or nothing is beside a sample. Before it, of samples within the picture: `name_at`, 0 where nothing is
// seen, `object_of` a name, `depth_of_sample`, and `place_of_sample`: where that surface is seen in one frame, in samples, and its
// depth there.
#include "toon/ink.glsl"
layout(constant_id = 1) const uint BY_STEPS = 0u;  // 1: the nearer sides of steps, all or nothing

const float STEEPEST = 2.0;  // what a surface may go back, of how far apart samples see it, before that is a step

ivec2 inside(ivec2 at) {
    return clamp(at, ivec2(0), 2 * ivec2(params.size) - 1);
}

float per_unit_at(float depth) {
    return 1.0 / (8.0 * toon.sample_extent * widening(depth));
}

// A step down from a place to what is beside it, to both sides of it along a row, a column and both diagonals: as a second difference,
// so that slopes make none. Infinite before another object or nothing; what is before the place makes none either. Where the
// mesh is distorted, samples that are side by side see places that are not: a surface may then go back as far as it is steep.
float step_at(ivec2 at, uint own) {
    float depth = depth_of_sample(at);
    vec3 centre = place_of_sample(at);
    float per_unit = per_unit_at(centre.z);
    float largest = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 way = i < 2 ? ivec2(i, 1 - i) : ivec2(1, 2 * i - 5);
        float difference = 0.0;
        for (int side = -1; side <= 1; side += 2) {
            ivec2 there = inside(at + side * way);
            uint other = name_at(there);
            if (other == 0u) {
                return INFINITY;
            }
            if (object_of(other) == object_of(own)) {
                vec3 place = place_of_sample(there);
                float apart = max(length(place.xy - centre.xy) - length(vec2(way)), 0.0);
                float back = (place.z - centre.z) * per_unit;
                difference += sign(back) * max(abs(back) - STEEPEST / 8.0 * apart, 0.0);
            } else if (depth_of_sample(there) >= depth) {
                return INFINITY;
            }
        }
        largest = max(largest, difference);
    }
    return largest;
}

float fading_at(ivec2 at, uint own) {
    float centre = depth_of_sample(at);
    vec4 beside;
    for (int i = 0; i < 4; ++i) {
        ivec2 there = inside(at + ivec2(i == 1 || i == 3 ? 1 : -1, i == 0 || i == 3 ? 1 : -1));
        uint other = name_at(there);
        if (other == 0u || object_of(other) != object_of(own)) {
            return 1.0;
        }
        beside[i] = depth_of_sample(there);
    }
    return ink_at(centre, beside, per_unit_at(centre), toon.ink_strength);
}

float line_at(ivec2 at) {
    uint own = name_at(at);
    if (own == 0u) {
        return 0.0;
    }
    if (BY_STEPS != 0u) {
        return step_at(at, own) * toon.ink_strength > 1.0 ? 1.0 : 0.0;
    }
    return fading_at(at, own);
}
