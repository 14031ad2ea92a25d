// One quad an occupied tile.
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };

void main() {
    uint tile = occupied_tiles[gl_InstanceIndex];
    uvec2 corner = uvec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    uvec2 at = min((uvec2(tile % params.image.z, tile / params.image.z) + corner) * TILE, params.image.xy);
    gl_Position = vec4(2.0 * vec2(at) / vec2(params.image.xy) - 1.0, 0.0, 1.0);
}
