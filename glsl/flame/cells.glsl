// Which cells of the screen a particle's sprites can touch, and in which depth bucket they begin. Level l has square cells
// of TILE * 2^l pixels; a particle stands at the finest level where it touches at most CELLS_ACROSS cells across and down.
#include "../common/sphere.glsl"
#include "../common/bits.glsl"

// Half a sprite in metres at a view depth, across and down.
vec2 half_sprite(float z) {
    float side = 0.5 * params.sprite_size;
    // No sprite is narrower than a pixel.
    return params.is_in_pixels != 0u ? max(side, 0.5) * params.pixel_slope * widening(z) : vec2(max(side, 0.5 * params.pixel_footprint * widening(z)));
}

// Slopes between which what is so far around a place is seen along an axis.
vec2 slope_range(float x, float z, float r) {
    return params.is_orthographic != 0u ? vec2(x - r, x + r) : tangent_range(x, z, r);
}

// Bounds of a particle's sprites in pixels (low x, low y, high x, high y), of which the share `reach` matters, and which are
// drawn out to reach so much farther across and down.
vec4 pixel_bounds(vec3 view, float reach, vec2 farther) {
    float near = max(view.z - params.bounding_radius, params.near);
    float far = min(view.z + params.bounding_radius, params.far);
    if (near > far) {
        return vec4(1.0, 1.0, 0.0, 0.0);
    }
    vec2 r = farther * (params.bounding_radius + reach * half_sprite(view.z + params.bounding_radius));
    // Depth alone does not bound what is around the camera.
    if (params.is_orthographic == 0u && view.z <= 1.001 * max(r.x, r.y)) {
        return vec4(0.0, 0.0, vec2(params.size));
    }
    vec2 across = slope_range(view.x, view.z, r.x);
    vec2 down = slope_range(-view.y, view.z, r.y);
    vec4 pixels = params.focal_length.xyxy * vec4(across.x, down.x, across.y, down.y);
    // Rounding: a thousandth of a pixel is more than it can be.
    return params.principal_point.xyxy + pixels + vec4(-1e-3, -1e-3, 1e-3, 1e-3) + 1e-5 * abs(pixels) * vec4(-1.0, -1.0, 1.0, 1.0);
}

// Whether such bounds hold the centre of a pixel.
bool on_screen(vec4 bounds) {
    return bounds.x <= bounds.z && all(lessThan(bounds.xy, vec2(params.size))) && all(greaterThan(bounds.zw, vec2(0.0)));
}

// The level at which a particle of such bounds stands, and its first and last cell there.
uint cells_of(vec4 bounds, out uvec4 cells) {
    vec4 tile = floor(bounds / float(TILE));
    uvec4 tiles = uvec4(clamp(tile, vec4(0.0), vec4(vec2(params.tiles - 1u), vec2(params.tiles - 1u))));
    uint level = 0u;
    while (max((tiles.z >> level) - (tiles.x >> level), (tiles.w >> level) - (tiles.y >> level)) >= CELLS_ACROSS) {
        ++level;
    }
    cells = tiles >> level;
    return level;
}

uint cell_index(uint level, uint x, uint y) {
    return params.cell_levels[level].first + y * params.cell_levels[level].across + x;
}

// The bucket of a view depth. Rounding is monotonous: what is nearer is never in a later bucket.
uint bucket_of(float z, float low, float per_metre) {
    return uint(clamp(floor((z - low) * per_metre), 0.0, float(params.bucket_count) - 1.0));
}

// The nearest that a particle's render particles can be, and a little nearer than rounding can make it.
float nearest_of(float z) {
    return z - params.bounding_radius - 1e-6 * (abs(z) + params.bounding_radius);
}
