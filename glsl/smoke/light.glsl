// Light-space tiles: square grids, one a level, level l with 2^l cells a side; a face for a directional light, six for a
// point light. A sphere stands in the cells that it touches at the level where its diameter is at most CELLS_ACROSS cells.
// The list of a cell is in order of buckets, nearest to the light first: what lies behind a surface is never looked at.
#include "../common/sphere.glsl"
#include "cells.glsl"
#include "light_space.glsl"
layout(constant_id = 0) const float CELLS_ACROSS = 4.0;

const float FACE_MARGIN = 1.0001;

bool is_point_light() {
    return params.is_point_light != 0u;
}

// A vector from a point light as a face sees it: x, y across, z ahead.
vec3 on_face(vec3 v, uint face) {
    vec3 turned = face / 2u == 0u ? v.yzx : face / 2u == 1u ? v.zxy : v;
    return (face & 1u) == 0u ? turned : vec3(turned.y, turned.x, -turned.z);
}

uint face_of(vec3 v) {
    vec3 size = abs(v);
    uint axis = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
    return 2u * axis + (v[axis] < 0.0 ? 1u : 0u);
}

// Position on a face, 0 to 1.
vec2 face_position(vec3 p, uint face) {
    if (is_point_light()) {
        vec3 v = on_face(p - params.light.xyz, face);
        return 0.5 + 0.5 * v.xy / max(v.z, 1e-30);
    }
    return (in_light_space(p).xy - params.light_low) * params.light_inverse_side;
}

// Bounds of a sphere on a face, 0 to 1 (low xy, high xy); low > high where it does not touch the face.
vec4 face_bounds(vec4 sphere, uint face) {
    // A near miss at distance t counts within softness * t of the sphere.
    if (!is_point_light()) {
        float r = sphere.w + params.softness * params.caster_distance;
        vec2 at = face_position(sphere.xyz, face);
        return vec4(at - r * params.light_inverse_side, at + r * params.light_inverse_side);
    }
    vec3 v = on_face(sphere.xyz - params.light.xyz, face);
    // Seen from the pixel the sphere is `softness * t` larger, t at most the way to the light.
    float r = sphere.w + params.softness * params.caster_distance;
    if (v.z <= r * FACE_MARGIN) {
        // The light is inside, or the sphere reaches behind the face: all of the face, if any.
        return v.z + r * FACE_MARGIN > 0.0 ? vec4(0.0, 0.0, 1.0, 1.0) : vec4(1.0, 1.0, 0.0, 0.0);
    }
    vec2 across = tangent_range(v.x, v.z, r);
    vec2 down = tangent_range(v.y, v.z, r);
    vec4 bounds = 0.5 + 0.5 * vec4(across.x, down.x, across.y, down.y);
    bool outside = any(greaterThan(bounds.xy, vec2(1.0))) || any(lessThan(bounds.zw, vec2(0.0)));
    return outside ? vec4(1.0, 1.0, 0.0, 0.0) : clamp(bounds, 0.0, 1.0);
}

// The cells that a sphere stands in: level and corners, both included. False if it does not touch the face.
bool cells_of(vec4 sphere, uint face, out uint level, out uvec4 cells) {
    vec4 bounds = face_bounds(sphere, face);
    if (bounds.x > bounds.z || bounds.y > bounds.w) {
        return false;
    }
    // Rounding in the look-up may differ from rounding here by a few units in the last place.
    bounds += vec4(-1e-5, -1e-5, 1e-5, 1e-5);
    float size = max(bounds.z - bounds.x, bounds.w - bounds.y);
    float finest = floor(log2(CELLS_ACROSS / max(size, 1e-9)));
    level = uint(clamp(finest, 0.0, float(params.light_levels) - 1.0));
    float side = float(1u << level);
    cells = uvec4(clamp(floor(bounds * side), vec4(0.0), vec4(side - 1.0)));
    return true;
}

uint cell_at(uint face, uint level, vec2 position) {
    float side = float(1u << level);
    uvec2 cell = uvec2(clamp(floor(position * side), vec2(0.0), vec2(side - 1.0)));
    return first_cell(face, level) + cell.y * (1u << level) + cell.x;
}

// The bucket of a place by how far it is from the light; 0 is nearest. Rounding is monotonous, so that whatever is
// nearer is never in a later bucket.
uint bucket_of(float distance) {
    float share = (distance - params.light_nearest) * params.light_inverse_span;
    return uint(clamp(floor(share * float(BUCKETS)), 0.0, float(BUCKETS) - 1.0));
}

// Distance of a point from a point light, or from a plane across a directional light.
float light_distance(vec3 p) {
    return is_point_light() ? length(p - params.light.xyz) : -dot(params.light.xyz, p);
}

// Bucket of the nearest of a sphere; a unit in the last place nearer, so that rounding cannot put it behind what it
// shadows.
uint bucket_of_sphere(vec4 sphere) {
    return bucket_of(light_distance(sphere.xyz) - sphere.w * 1.0001);
}
