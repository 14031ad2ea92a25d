// Triangles in pixel clip coordinates.
#include "common/widening.glsl"

float cross2(vec2 a, vec2 b) {
    return a.x * b.y - a.y * b.x;
}

// Edge functions of a triangle in clip coordinates at a place of the picture: barycentrics in what is seen of
// its plane there, but for their sum, which is 0 where there is no plane.
vec3 edges_at(vec3 a, vec3 b, vec3 c, vec2 at) {
    vec2 p = a.xy - at * widening(a.z);
    vec2 q = b.xy - at * widening(b.z);
    vec2 r = c.xy - at * widening(c.z);
    return vec3(cross2(q, r), cross2(r, p), cross2(p, q));
}

// Above 0 where a triangle is seen from the side from which it runs clockwise in the world, below from the other, wherever its corners are.
float volume_of(vec3 a, vec3 b, vec3 c) {
    return params.winding * dot(vec3(a.xy, widening(a.z)), cross(vec3(b.xy, widening(b.z)), vec3(c.xy, widening(c.z))));
}
