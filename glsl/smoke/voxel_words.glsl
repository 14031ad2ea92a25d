// How voxels lie in words: a bit of occupancy each, a byte of the distance field each, rows along x.
#ifndef VOXEL_WORDS
#define VOXEL_WORDS

const uint WORD_VOXELS = 32u;     // of a word of occupancy
const uint FIELD_VOXELS = 4u;     // of a word of the distance field
const int FIELD_FARTHEST = 255;   // distance that the field can hold, voxels
const uint BIRTH_BLOCK = 256u;    // words of occupancy whose births are counted together
const uint DETAIL_RUN = 8u;       // voxels along y, then along z, that are smoothed together
const uint DETAIL_COLUMNS = 4u;   // voxels along x, beside those along y
const uint CROSSING_ROWS = 8u;    // of cells, along y and z, that a workgroup begins with
const uint CROSSING_LEVELS = 3u;  // that it makes above them

// Row of voxels of a volume.
uint row_of(uint y, uint z) {
    return z * params.dimensions.y + y;
}

uint occupancy_word(ivec3 v) {
    return row_of(uint(v.y), uint(v.z)) * params.row_words + uint(v.x) / WORD_VOXELS;
}

// Words of a row of the distance field.
uint field_row_words() {
    return (params.dimensions.x + FIELD_VOXELS - 1u) / FIELD_VOXELS;
}

// Bits of voxels first .. last along x in a word whose lowest bit is voxel `start`.
uint voxel_bits(int start, int first, int last) {
    int low = clamp(first - start, 0, 32);
    int high = clamp(last + 1 - start, 0, 32);
    if (low >= high) {
        return 0u;
    }
    uint below_high = high == 32 ? 0xffffffffu : (1u << uint(high)) - 1u;
    return below_high & (0xffffffffu << uint(low));
}

#endif
