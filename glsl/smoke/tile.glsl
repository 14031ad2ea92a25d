// Kernels over the pixels of occupied tiles: a workgroup a tile, some rows of it at a time.
#include "screen.glsl"
layout(local_size_x = TILE, local_size_y = 8) in;
layout(std430, binding = 1) readonly buffer OccupiedTiles { uint occupied_tiles[]; };

// What is done at a pixel.
void work_on(uvec2 at);

void main() {
    uvec2 corner = tile_at(occupied_tiles[gl_WorkGroupID.x]) * TILE;
    for (uint row = 0u; row < TILE; row += gl_WorkGroupSize.y) {
        uvec2 at = corner + uvec2(gl_LocalInvocationID.x, gl_LocalInvocationID.y + row);
        if (is_in_picture(at)) {
            work_on(at);
        }
    }
}
