// Exclusive prefix sums that many workgroups share. A list is cut into blocks, one a workgroup. A first dispatch writes each block's sum to
// `block_sums`; in a second one each block adds up what is before it, and goes on in itself (reduce, then scan: Blelloch 1990; no workgroup
// waits for another). Before this file is included, SCAN_TYPE is what is summed: uint, or uvec2 for two sums at once.
#ifndef SCAN
#define SCAN

const uint SCAN_ROW = 16u;  // invocations whose values one of them adds up
const uint SCAN_ROWS = gl_WorkGroupSize.x * gl_WorkGroupSize.y / SCAN_ROW;
shared SCAN_TYPE scan_sums[SCAN_ROWS * (SCAN_ROW + 1u)];  // a row's sum stands after it
struct Scan {
    SCAN_TYPE before;
    SCAN_TYPE all;
};

// Over the invocations of a workgroup: along rows, then over the sums of rows. Few barriers, and no two invocations wait for a bank of memory.
Scan scan_workgroup(SCAN_TYPE own) {
    uint lane = gl_LocalInvocationIndex;
    uint place = lane + lane / SCAN_ROW;
    barrier();
    scan_sums[place] = own;
    barrier();
    if (lane < SCAN_ROWS) {
        uint first = lane * (SCAN_ROW + 1u);
        SCAN_TYPE sum = SCAN_TYPE(0u);
        for (uint i = first; i < first + SCAN_ROW; ++i) {
            SCAN_TYPE value = scan_sums[i];
            scan_sums[i] = sum;
            sum += value;
        }
        scan_sums[first + SCAN_ROW] = sum;
    }
    barrier();
    Scan scan = Scan(scan_sums[place], SCAN_TYPE(0u));
    for (uint row = 0u; row < SCAN_ROWS; ++row) {
        SCAN_TYPE sum = scan_sums[row * (SCAN_ROW + 1u) + SCAN_ROW];
        scan.before += row < lane / SCAN_ROW ? sum : SCAN_TYPE(0u);
        scan.all += sum;
    }
    return scan;
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
