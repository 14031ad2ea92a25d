// How far a place is along a direction.
float along(vec2 d, vec2 q) {
    precise float p = d.x * q.x + d.y * q.y;
    return p;
}
