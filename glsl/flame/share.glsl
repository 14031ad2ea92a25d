// A list that one workgroup goes over: each invocation has a share of it, in order.
shared uint lane_sums[gl_WorkGroupSize.x];

// The first element of the invocation's share, and the one after the last.
uvec2 share_of_list(uint count) {
    uint share = (count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint first = min(gl_LocalInvocationID.x * share, count);
    return uvec2(first, min(first + share, count));
}

// Exclusive prefix sum over the invocations, and the sum of all.
uvec2 prefix_sum(uint own) {
    uint lane = gl_LocalInvocationID.x;
    lane_sums[lane] = own;
    barrier();
    uint before = 0u;
    uint total = 0u;
    for (uint i = 0u; i < gl_WorkGroupSize.x; ++i) {
        before += i < lane ? lane_sums[i] : 0u;
        total += lane_sums[i];
    }
    return uvec2(before, total);
}
