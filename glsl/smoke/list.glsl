// What counting and listing spheres share: the same flags, computed twice, so that lists come out in particle order
// without atomics.
bool is_live(vec4 sphere) {
    return sphere.w > 0.0;
}

const float SHRUNK_AWAY = 0.1;  // of a radius: what has shrunk below it is nothing

// The radius that a sphere is drawn with: those that are small in the picture shrink to nothing, and do not pop. They are
// spheres still to all that does not depend on the camera.
float drawn_radius(float radius, float depth) {
    float pixels = 2.0 * radius / (params.pixel_footprint * widening(max(depth, params.near)));
    float t = params.smallest > 0.0 ? clamp(2.0 * pixels / params.smallest - 1.0, 0.0, 1.0) : 1.0;
    return radius * max(0.0, (t * t * (3.0 - 2.0 * t) - SHRUNK_AWAY) / (1.0 - SHRUNK_AWAY));
}

bool is_visible(vec4 view_sphere) {
    return view_sphere.w > 0.0 && can_be_seen(view_sphere.xyz, view_sphere.w);
}
