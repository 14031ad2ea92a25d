// What the two passes of the masked Gaussian share (paper, section 3.3, as a normalised convolution per group: exact).
// A thread makes eight neighbouring results.
#include "pixel.glsl"
#include "reach.glsl"
#include "screen.glsl"
layout(local_size_x = BLOCK, local_size_y = TILE_BLOCKS * TILE_BLOCKS) in;
layout(std430, binding = 1) readonly buffer Weights { float weights[]; };  // by distance, 0 beyond the window
layout(std430, binding = 2) readonly buffer Reached { Reach reached[]; };

const int TAPS = int(BLOCK);

float numerator[TAPS];
float denominator[TAPS];

void clear_sums() {
    for (int o = 0; o < TAPS; ++o) {
        numerator[o] = 0.0;
        denominator[o] = 0.0;
    }
}

#include "toon/gaussian.glsl"

void add_taps(float w[2 * TAPS - 1], float values[TAPS], float masks[TAPS]) {
    add_values(numerator, w, values);
    add_values(denominator, w, masks);
}

// Place of a block's row in the slot of a tile's sums.
uint slot_row(uint block, uint row) {
    return (block / TILE_BLOCKS * BLOCK + row) * TILE + block % TILE_BLOCKS * BLOCK;
}

// Where the row sums of a tile begin: as many groups or planes have places as are in memory at a time, and later ones take those of
// earlier ones.
uint slot_of(uint tile, uint group) {
    return (group % params.row_groups * params.tiles.x * params.tiles.y + tile) * SLOT_PIXELS;
}
