// What counting and listing spheres share: the same flags, computed twice, so that lists come out in particle order
// without atomics.
bool is_live(vec4 sphere) {
    return sphere.w > 0.0;
}

bool is_visible(vec4 view_sphere) {
    return can_be_seen(view_sphere.xyz, view_sphere.w);
}
