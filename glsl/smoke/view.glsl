// Between view space and pixels.
#include "../common/view.glsl"

vec3 to_world_direction(vec3 v) {
    return params.camera.right.xyz * v.x + params.camera.up.xyz * v.y + params.camera.forward.xyz * v.z;
}

// The ray through a pixel's centre, with z = 1: its parameter is the view depth.
vec3 pixel_ray(vec2 centre) {
    precise vec2 ndc = 2.0 * centre / vec2(params.size) - 1.0;
    return vec3(ndc.x * params.half_extent.x, -ndc.y * params.half_extent.y, 1.0);
}

// Whether a sphere in view space can touch the screen between near and far.
bool can_be_seen(vec3 c, float r) {
    vec2 slope = params.half_extent;
    vec2 reach = r * 1.0001 * sqrt(1.0 + slope * slope);
    return c.z + r >= params.near && c.z - r <= params.far && abs(c.x) - c.z * slope.x <= reach.x
        && abs(c.y) - c.z * slope.y <= reach.y;
}

// The front of a sphere along a pixel's ray: depth, and the unit normal; false if the ray passes by. Everything is taken
// from the perpendicular from the centre to the ray, made perpendicular twice, so that nothing large cancels.
bool hit_sphere(vec3 ray, vec4 sphere, out float depth, out vec3 normal) {
    precise float a = dot(ray, ray);
    precise float closest = dot(ray, sphere.xyz) / a;
    precise vec3 across = sphere.xyz - closest * ray;
    precise float rest = dot(ray, across) / a;
    across -= rest * ray;
    precise float inside = sphere.w * sphere.w - dot(across, across);
    precise float half_chord = sqrt(max(inside, 0.0) / a);
    depth = closest + (rest - half_chord);
    normal = (across + half_chord * ray) / -sphere.w;
    return inside >= 0.0;
}
