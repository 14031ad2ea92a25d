// Between world, view and pixels. View space: x right, y up, z = view depth, in metres.
#include "../common/exact.glsl"

// One row of the view rotation times the way from the eye, each given as a sum of two floats.
float along_row(vec3 row, vec3 row_low, vec3 q, vec3 q_low) {
    vec2 x = two_product(row.x, q.x);
    vec2 y = two_product(row.y, q.y);
    vec2 z = two_product(row.z, q.z);
    vec2 xy = two_sum(x.x, y.x);
    vec2 xyz = two_sum(xy.x, z.x);
    float low = x.y + y.y + z.y + xy.y + xyz.y + dot(row, q_low) + dot(row_low, q);
    return xyz.x + low;
}

// World to view space, rounded once: what a small sphere far away looks like depends on the last bits.
vec3 to_view(vec3 p) {
    vec2 x = two_sum(p.x, -params.eye.x);
    vec2 y = two_sum(p.y, -params.eye.y);
    vec2 z = two_sum(p.z, -params.eye.z);
    vec3 q = vec3(x.x, y.x, z.x);
    vec3 q_low = vec3(x.y, y.y, z.y) - params.eye_low.xyz;
    return vec3(along_row(params.right.xyz, params.right_low.xyz, q, q_low),
                along_row(params.up.xyz, params.up_low.xyz, q, q_low),
                along_row(params.forward.xyz, params.forward_low.xyz, q, q_low));
}

vec3 to_world_direction(vec3 v) {
    return params.right.xyz * v.x + params.up.xyz * v.y + params.forward.xyz * v.z;
}

// The ray through a pixel's centre, with z = 1: its parameter is the view depth.
vec3 pixel_ray(vec2 centre) {
    precise vec2 ndc = 2.0 * centre / vec2(params.image.xy) - 1.0;
    return vec3(ndc.x * params.lens.x, -ndc.y * params.lens.y, 1.0);
}

// Whether a sphere in view space can touch the screen between near and far.
bool can_be_seen(vec3 c, float r) {
    vec2 slope = params.lens.xy;
    vec2 reach = r * 1.0001 * sqrt(1.0 + slope * slope);
    return c.z + r >= params.lens.z && c.z - r <= params.lens.w && abs(c.x) - c.z * slope.x <= reach.x
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
