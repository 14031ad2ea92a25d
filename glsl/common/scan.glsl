// Exclusive prefix sums that many workgroups share. A list is cut into blocks, one a workgroup. A first dispatch writes each block's sum to
// `block_sums`; in a second one each block adds up what is before it, and goes on in itself (reduce, then scan: Blelloch 1990; no workgroup
// waits for another). Before this file is included, SCAN_TYPE is what is summed: uint, or uvec2 for two sums at once.
#ifndef SCAN
#define SCAN

shared SCAN_TYPE scan_sums[gl_WorkGroupSize.x];

struct Scan {
    SCAN_TYPE before;
    SCAN_TYPE all;
};

// Over the invocations of a workgroup.
Scan scan_workgroup(SCAN_TYPE own) {
    uint lane = gl_LocalInvocationIndex;
    barrier();
    scan_sums[lane] = own;
    for (uint reach = 1u; reach < gl_WorkGroupSize.x; reach *= 2u) {
        barrier();
        SCAN_TYPE before = lane >= reach ? scan_sums[lane - reach] : SCAN_TYPE(0u);
        barrier();
        scan_sums[lane] += before;
    }
    barrier();
    return Scan(scan_sums[lane] - own, scan_sums[gl_WorkGroupSize.x - 1u]);
}

#ifdef SCAN_BLOCKS
// Over blocks: the sum of those before one, and of the first `count`. All invocations of a workgroup ask for the same.
Scan scan_blocks(uint block, uint count) {
    Scan own = Scan(SCAN_TYPE(0u), SCAN_TYPE(0u));
    for (uint i = gl_LocalInvocationIndex; i < count; i += gl_WorkGroupSize.x) {
        SCAN_TYPE sum = block_sums[i];
        own.before += i < block ? sum : SCAN_TYPE(0u);
        own.all += sum;
    }
    return Scan(scan_workgroup(own.before).all, scan_workgroup(own.all).all);
}
#endif

#endif
