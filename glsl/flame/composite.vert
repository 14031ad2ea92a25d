// Occupied tiles.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/composite_vertex.glsl"

void main() {
    gl_Position = tile_corner(params.size, params.tiles.x);
}
