// Which share of a pixel smoke covers, in closed form: by how far the ray through its middle passes from the outline of a sphere, in
// pixels. Of the spheres that the pixel and those around it see, the one that covers the most of it counts. To be included with
// `seen` and `view_spheres` bound.

// So much of a pixel as lies on the inner side of a line at a distance from its middle, in pixels, inside below 0.
float share_inside(float way) {
    return clamp(0.5 - way, 0.0, 1.0);
}

// Of a sphere. The distance of the ray from its centre is its radius on the outline; along the picture it grows by `growth` a pixel.
float sphere_coverage(Ray ray, vec4 sphere) {
    precise vec3 centre = sphere.xyz - ray.from;
    float a = dot(ray.way, ray.way);
    precise float closest = dot(ray.way, centre) / a;
    precise vec3 across = centre - closest * ray.way;
    across -= dot(ray.way, across) / a * ray.way;
    float away = length(across);
    vec2 step_size = 2.0 * params.half_extent / vec2(params.size);
    float growth = widening(max(closest, params.near)) * length(across.xy * step_size);
    // In the middle of the sphere the outline is as far as it can be.
    return growth > 0.0 ? share_inside((away - sphere.w) * away / growth) : 1.0;
}

uint seen_at(ivec2 at) {
    return is_in_picture(uvec2(at)) ? imageLoad(seen, at).x : 0u;
}

// `source`: the pixel whose colour it has: itself, or one beside it if it sees no smoke.
float coverage_of(ivec2 at, out ivec2 source) {
    source = at;
    bool is_seen = seen_at(at) != 0u;
    float most = is_seen ? 0.5 : 0.0;
    bool is_edge = false;
    for (int i = 0; i < 9; ++i) {
        ivec2 beside = at + ivec2(i % 3, i / 3) - 1;
        is_edge = is_edge || is_in_picture(uvec2(beside)) && imageLoad(seen, beside).x == 0u;
    }
    if (!is_edge) {
        return 1.0;
    }
    Ray ray = pixel_ray(vec2(at) + 0.5);
    for (int i = 0; i < 9; ++i) {
        ivec2 beside = at + ivec2(i % 3, i / 3) - 1;
        uint code = seen_at(beside);
        float share = code != 0u ? sphere_coverage(ray, view_spheres[(code >> GROUP_BITS) - 1u]) : 0.0;
        // Where the near plane has cut a sphere open, its middle is empty: there is no outline.
        if (share > most && (is_seen || share <= 0.5)) {
            most = share;
            source = is_seen ? at : beside;
        }
    }
    return most;
}
