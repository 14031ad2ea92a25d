// Workgroups that share out the pixels of a tile: each invocation has a column of them, within a block. How many invocations a workgroup has follows
// from the device (`Tuning`): columns of 8 pixels suit drivers that pack invocations into vectors, a pixel each suits GPUs. No bit depends on it.
layout(local_size_x = 32, local_size_x_id = 0) in;
layout(constant_id = 0) const uint LANES = 32;
const int ROWS = int(TILE * TILE / LANES);  // pixels of a column

// What a workgroup takes up at a time: as many as it has invocations, but half of 256, for which shared memory has no room.
const uint BATCH = LANES - LANES / 256u * 128u;

// Whether an invocation has one of a batch.
bool is_in_batch() {
    return LANES == BATCH || gl_LocalInvocationID.x < BATCH;
}

struct Column {
    uint block;   // of the tile
    uvec2 corner; // the block's, in the tile
    uint x;       // in the block
    int row;      // the column's first, in the block
};

Column own_column() {
    uint block = gl_LocalInvocationID.x / (LANES / BLOCKS);
    uint place = gl_LocalInvocationID.x % (LANES / BLOCKS);
    return Column(block, block_corner(block), place % BLOCK, ROWS == int(BLOCK) ? 0 : int(place / BLOCK) * ROWS);
}

layout(push_constant) uniform AccumulateConstants {
    uint part;   // which dispatch of the stage this is
    uint first;  // repetition, or bin, of the stage
    uint last;   // the one after its last
} constants;
