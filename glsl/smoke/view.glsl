// Between view space and pixels.
#include "../common/view.glsl"
#include "../common/widening.glsl"

vec3 to_world_direction(vec3 v) {
    return params.camera.right.xyz * v.x + params.camera.up.xyz * v.y + params.camera.forward.xyz * v.z;
}

// The ray through a place of the picture, in view space: its parameter is the view depth.
struct Ray {
    vec3 from;
    vec3 way;  // z is 1
};

Ray pixel_ray(vec2 centre) {
    precise vec2 ndc = 2.0 * centre / vec2(params.size) - 1.0;
    vec2 slope = vec2(ndc.x, -ndc.y) * params.half_extent + params.off_axis;
    bool is_parallel = params.is_orthographic != 0u;
    return Ray(is_parallel ? vec3(slope, 0.0) : vec3(0.0), vec3(is_parallel ? vec2(0.0) : slope, 1.0));
}

// Whether a sphere in view space can touch the screen between near and far.
bool can_be_seen(vec3 c, float r) {
    vec2 low = params.off_axis - params.half_extent;
    vec2 high = params.off_axis + params.half_extent;
    bool is_parallel = params.is_orthographic != 0u;
    vec2 reach_low = r * 1.0001 * (is_parallel ? vec2(1.0) : sqrt(1.0 + low * low));
    vec2 reach_high = r * 1.0001 * (is_parallel ? vec2(1.0) : sqrt(1.0 + high * high));
    return c.z + r >= params.near && c.z - r <= params.far && all(lessThanEqual(low * widening(c.z) - c.xy, reach_low))
        && all(lessThanEqual(c.xy - high * widening(c.z), reach_high));
}

// The front of a sphere along a pixel's ray: depth, and the unit normal; false if the ray passes by. Everything is taken
// from the perpendicular from the centre to the ray, made perpendicular twice, so that nothing large cancels.
bool hit_sphere(Ray ray, vec4 sphere, out float depth, out vec3 normal) {
    vec3 way = ray.way;
    precise vec3 centre = sphere.xyz - ray.from;
    precise float a = dot(way, way);
    precise float closest = dot(way, centre) / a;
    precise vec3 across = centre - closest * way;
    precise float rest = dot(way, across) / a;
    across -= rest * way;
    precise float inside = sphere.w * sphere.w - dot(across, across);
    precise float half_chord = sqrt(max(inside, 0.0) / a);
    depth = closest + (rest - half_chord);
    normal = (across + half_chord * way) / -sphere.w;
    return inside >= 0.0;
}
