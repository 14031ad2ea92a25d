// Passes that make the chessboard distance field: an invocation a word.
#include "voxel_words.glsl"
layout(local_size_x = 64) in;

// False where there is no word. A slice is a row of workgroups: all of them along one axis may be more than a device takes.
bool own_word(out uint index) {
    uint slice = field_row_words() * params.dimensions.y;
    index = gl_GlobalInvocationID.y * slice + gl_GlobalInvocationID.x;
    return gl_GlobalInvocationID.x < slice;
}
