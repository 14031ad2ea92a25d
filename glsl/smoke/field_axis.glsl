// Chessboard distance field, one more axis: d(x) = min over j of max(|j|, d'(x + j)). Exact, because the chessboard
// distance is the maximum over axes. Four voxels a word.
#include "field_pass.glsl"
layout(std430, binding = 1) readonly buffer FROM { uint field_from[]; };
layout(std430, binding = 2) writeonly buffer TO { uint field_to[]; };

ivec4 unpack(uint v) {
    return ivec4(v, v >> 8, v >> 16, v >> 24) & FIELD_FARTHEST;
}

void main() {
    uint index;
    if (!own_word(index)) {
        return;
    }
    uint packed_row = field_row_words();
    uint stride = AXIS == 1 ? packed_row : packed_row * params.dimensions.y;
    int count = int(AXIS == 1 ? params.dimensions.y : params.dimensions.z);
    int at = int(AXIS == 1 ? index / packed_row % params.dimensions.y : index / packed_row / params.dimensions.y);
    ivec4 best = unpack(field_from[index]);
    int most = max(max(best.x, best.y), max(best.z, best.w));
    for (int j = 1; j < most; ++j) {
        ivec4 near = ivec4(0);
        if (at - j >= 0 && at + j < count) {
            near = min(unpack(field_from[index - uint(j) * stride]), unpack(field_from[index + uint(j) * stride]));
        }
        best = min(best, max(ivec4(j), near));
        most = max(max(best.x, best.y), max(best.z, best.w));
    }
    field_to[index] = uint(best.x) | uint(best.y) << 8 | uint(best.z) << 16 | uint(best.w) << 24;
}
