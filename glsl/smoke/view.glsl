// Between world, view and pixels. View space: x right, y up, z = view depth, in metres.
vec3 to_view(vec3 p) {
    precise vec3 q = (p - params.eye.xyz) - params.eye_low.xyz;
    precise float x = params.right.x * q.x + params.right.y * q.y + params.right.z * q.z;
    precise float y = params.up.x * q.x + params.up.y * q.y + params.up.z * q.z;
    precise float z = params.forward.x * q.x + params.forward.y * q.y + params.forward.z * q.z;
    return vec3(x, y, z);
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

// Depth of the front of a sphere along a pixel's ray; negative if the ray passes by. The distance from the centre to
// the ray is taken from the perpendicular itself, which does not cancel as b^2 - ac does.
float front_depth(vec3 ray, vec3 c, float r) {
    precise float a = dot(ray, ray);
    precise float closest = dot(ray, c) / a;
    precise vec3 across = c - closest * ray;
    precise float inside = r * r - dot(across, across);
    return inside < 0.0 ? -1.0 : closest - sqrt(inside / a);
}
