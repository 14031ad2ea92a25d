// One quad an occupied tile.
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };

// A corner of its quad, in normalised device coordinates, in a picture of `size` pixels.
vec4 tile_corner(uvec2 size, uint tiles_across) {
    uint tile = occupied_tiles[gl_InstanceIndex];
    uvec2 corner = uvec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    uvec2 at = min((uvec2(tile % tiles_across, tile / tiles_across) + corner) * TILE, size);
    return vec4(2.0 * vec2(at) / vec2(size) - 1.0, 0.0, 1.0);
}
