// Words of a buffer that is summed up: blocks of so many for each workgroup, some vectors for each invocation.
#extension GL_GOOGLE_include_directive : require
const uint SCAN_LANES = 256u;
const uint SCAN_VECTORS = 4u;  // of four words, of an invocation
const uint SCAN_BLOCK = 4u * SCAN_VECTORS * SCAN_LANES;  // words of a block
layout(local_size_x = SCAN_LANES) in;
layout(push_constant) uniform ScanConstants { uint vectors; } constants;  // of four words, of the buffer

uint sum_of(uvec4 words) {
    return words.x + words.y + words.z + words.w;
}
