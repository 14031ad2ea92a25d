// Words of a buffer that is summed up: blocks of so many for each workgroup, a vector for each invocation.
#extension GL_GOOGLE_include_directive : require
const uint SCAN_LANES = 256u;
const uint SCAN_BLOCK = 4u * SCAN_LANES;  // words of a block
layout(local_size_x = SCAN_LANES) in;
layout(push_constant) uniform ScanConstants { uint vectors; } constants;  // of four words, of the buffer
