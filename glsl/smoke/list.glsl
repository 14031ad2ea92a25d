// What counting and listing spheres share: the same flags, computed twice, so that lists come out in particle order
// without atomics.
bool is_live(vec4 sphere) {
    return sphere.w > 0.0;
}

// The radius that a sphere is drawn with: those that are small in the picture shrink to nothing, as a ball does that sinks, and do
// not pop. That is fast at the end, so that few are specks. They are spheres still to all that does not depend on the camera.
float drawn_radius(float radius, float depth) {
    float pixels = 2.0 * radius / (params.pixel_footprint * widening(max(depth, params.near)));
    float t = params.smallest > 0.0 ? clamp(2.0 * pixels / params.smallest - 1.0, 0.0, 1.0) : 1.0;
    return radius * sqrt(t * (2.0 - t));
}

bool is_visible(vec4 view_sphere) {
    return view_sphere.w > 0.0 && can_be_seen(view_sphere.xyz, view_sphere.w);
}
