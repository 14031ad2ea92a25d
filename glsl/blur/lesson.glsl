// What a pixel that a frame shows teaches of the surface that it sees.

struct Lesson {
    bool is_there;  // it and its neighbours all see one surface, and no outline
    uint place;     // the triangle that it sees
    uvec4 base;     // its corners and surface
    vec3 barycentrics;  // in it, at the pixel's centre
};

bool is_same(uint frame, ivec2 at, uint surface) {
    return !is_in_picture(at) || is_seen(frame, at, surface);
}

// `frame`: 1 or 2, of frames i and i + 1.
Lesson lesson_of(uint frame, ivec2 at) {
    Lesson lesson = Lesson(false, 0u, uvec4(0u), vec3(0.0));
    uint seen = is_in_picture(at) ? seen_at(frame, at) : 0u;
    if (seen == 0u) {
        return lesson;
    }
    uvec4 base = triangles[seen - 1u];
    uint surface = surface_of(base.w);
    bool is_inner = is_same(frame, at - ivec2(1, 0), surface) && is_same(frame, at + ivec2(1, 0), surface)
        && is_same(frame, at - ivec2(0, 1), surface) && is_same(frame, at + ivec2(0, 1), surface);
    // What may be an outline says nothing of a surface.
    is_inner = is_inner && (cover_at(at) & OUTLINE << frame) == 0u;
    vec3 edges = edges_at(corner_of(frame, base.x), corner_of(frame, base.y), corner_of(frame, base.z), vec2(at) + 0.5);
    float sum = edges.x + edges.y + edges.z;
    return Lesson(is_inner && sum != 0.0, seen - 1u, base, edges / sum);
}
