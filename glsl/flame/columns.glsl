// Workgroups whose invocations are the columns of a tile's blocks.
const uint LANES = BLOCKS * BLOCK;
const int ROWS = int(BLOCK);  // pixels of a column

layout(push_constant) uniform AccumulateConstants {
    uint part;   // which dispatch of the stage this is
    uint first;  // repetition, or bin, of the stage
    uint last;   // the one after its last
} constants;
