// Two triangles a particle.
const uint CORNERS[PARTICLE_VERTICES] = uint[](0u, 1u, 2u, 2u, 1u, 3u);

uint particle_row() {
    return uint(gl_VertexIndex) / PARTICLE_VERTICES;
}

// Right or left, down or up.
vec2 particle_corner() {
    uint corner = CORNERS[uint(gl_VertexIndex) % PARTICLE_VERTICES];
    return vec2(corner & 1u, corner >> 1u);
}
