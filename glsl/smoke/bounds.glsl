// Where a sphere stands on the screen.
#include "../common/sphere.glsl"

// Whether the tangents from the eye bound it; if not, the eye plane cuts it or nearly does.
bool is_bounded(vec4 view_sphere) {
    return params.is_orthographic != 0u || view_sphere.z > view_sphere.w * 1.001;
}

// Bounds of the slopes along an axis at which a sphere that is bounded is seen.
vec2 slope_range(float x, float z, float r) {
    return params.is_orthographic != 0u ? vec2(x - r, x + r) : tangent_range(x, z, r);
}

// Bounds in pixels (low xy, high xy) of the image of a sphere that is bounded.
vec4 pixel_bounds(vec4 view_sphere) {
    vec2 across = (slope_range(view_sphere.x, view_sphere.z, view_sphere.w) - params.off_axis.x) / params.half_extent.x;
    vec2 down = -(slope_range(view_sphere.y, view_sphere.z, view_sphere.w) - params.off_axis.y).yx / params.half_extent.y;
    return (vec4(across.x, down.x, across.y, down.y) * 0.5 + 0.5) * vec4(params.size, params.size);
}
