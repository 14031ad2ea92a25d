// Chessboard distance field, first pass: for each voxel the distance along x to the nearest empty voxel, 0 in an empty
// one, at most 255; four voxels a word.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "field_pass.glsl"
layout(std430, binding = 1) readonly buffer Occupancy { uint occupancy[]; };
layout(std430, binding = 2) writeonly buffer Field { uint field[]; };

int nearest_empty(uint row, int x) {
    int words = int(params.row_words);
    int word = x / 32;
    uint here = ~occupancy[row * params.row_words + uint(word)];
    int bit = x % 32;
    if ((here >> uint(bit) & 1u) != 0u) {
        return 0;
    }
    // Outside is empty: voxels -1 and n end the search.
    int left = -1;
    uint candidates = here & ((1u << uint(bit)) - 1u);
    for (int w = word;;) {
        if (candidates != 0u) {
            left = w * 32 + findMSB(candidates);
            break;
        }
        if (--w < 0 || x - (w * 32 + 31) > FIELD_FARTHEST) {
            break;
        }
        candidates = ~occupancy[row * params.row_words + uint(w)];
    }
    int right = int(params.dimensions.x);
    candidates = bit == 31 ? 0u : here & 0xffffffffu << uint(bit + 1);
    for (int w = word;;) {
        if (candidates != 0u) {
            right = min(right, w * 32 + findLSB(candidates));
            break;
        }
        if (++w >= words || w * 32 - x > FIELD_FARTHEST) {
            break;
        }
        candidates = ~occupancy[row * params.row_words + uint(w)];
    }
    return min(min(x - left, right - x), FIELD_FARTHEST);
}

void main() {
    uint index;
    if (!own_word(index)) {
        return;
    }
    uint packed_row = field_row_words();
    uint row = index / packed_row;
    int x = int(index % packed_row * FIELD_VOXELS);
    uint distances = 0u;
    for (int i = 0; i < int(FIELD_VOXELS) && x + i < int(params.dimensions.x); ++i) {
        distances |= uint(nearest_empty(row, x + i)) << uint(8 * i);
    }
    field[index] = distances;
}
