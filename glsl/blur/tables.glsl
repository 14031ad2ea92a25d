// Colours by world normal: what is typical of each surface in each of frames i (0) and i + 1 (1).
#include "common/bits.glsl"
#include "bins.glsl"

// Where a table begins.
uint table_of(uint surface, uint frame) {
    return (2u * surface + frame) * BINS;
}

float sign_of(float value) {
    return value < 0.0 ? -1.0 : 1.0;
}

// The bin of a normal of any length in the octahedral map; NONE if it has no direction.
uint bin_of(vec3 normal) {
    float most = max(max(abs(normal.x), abs(normal.y)), abs(normal.z));
    if (!(most > 0.0 && most < INFINITY)) {
        return NONE;
    }
    normal /= most;
    normal /= abs(normal.x) + abs(normal.y) + abs(normal.z);
    vec2 at = normal.xy;
    if (normal.z < 0.0) {
        at = vec2((1.0 - abs(normal.y)) * sign_of(normal.x), (1.0 - abs(normal.x)) * sign_of(normal.y));
    }
    uvec2 place = min(uvec2(max((at * 0.5 + 0.5) * float(SIDE), 0.0)), uvec2(SIDE - 1u));
    return place.y * SIDE + place.x;
}

// Whether the normal of a triangle's corners points away from what is seen of it in a frame: to the inside of what is closed,
// else away from the eye.
bool is_turned(uint frame, uvec4 base) {
    if ((base.w & CLOSED) != 0u) {
        return (base.w & TURNED << frame) != 0u;
    }
    vec3 a = corner_of(frame + 1u, base.x);
    vec3 b = corner_of(frame + 1u, base.y);
    vec3 c = corner_of(frame + 1u, base.z);
    return volume_of(a, b, c) > 0.0;
}

// The normal that a frame has at a place.
vec3 normal_at(uint frame, uint place, uvec4 base, vec3 barycentrics) {
    uvec4 groups = corner_groups[place];
    uint first = frame * GROUPS;
    vec3 normal = barycentrics.x * normals[first + groups.x].xyz + barycentrics.y * normals[first + groups.y].xyz
        + barycentrics.z * normals[first + groups.z].xyz;
    return is_turned(frame, base) ? -normal : normal;
}

// The least power of two that no channel of either image is above, 1 to LARGEST_SCALE.
float scale_of_images() {
    float most = min(max(uintBitsToFloat(max(completing[SCALES], completing[SCALES + 1u])), 1.0), LARGEST_SCALE);
    float scale = 1.0;
    for (uint i = 0u; i < 4u; ++i) {
        scale = scale < most ? 2.0 * scale : scale;
    }
    return scale;
}

uvec4 quantised(vec4 colour, float scale) {
    uvec4 units;
    for (uint i = 0u; i < 4u; ++i) {
        precise float value = colour[i] * (UNITS / scale) + 0.5;
        units[i] = value > 0.0 ? uint(min(value, UNITS - 1.0)) : 0u;
    }
    return units;
}
