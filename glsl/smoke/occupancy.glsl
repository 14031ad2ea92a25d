// Whether a voxel is occupied, of the occupancy that the including kernel reads; outside of the volume none is.
#include "voxel_words.glsl"

bool is_occupied(ivec3 v) {
    return is_inside(v) && (occupancy[occupancy_word(v)] >> (uint(v.x) % WORD_VOXELS) & 1u) != 0u;
}
