// Kernels of one workgroup, each invocation of which works on a run of a list.
layout(local_size_x = 256) in;

// First entry of this invocation's run, and the one after the last.
uvec2 own_run(uint count) {
    uint run = (count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint first = min(gl_LocalInvocationID.x * run, count);
    return uvec2(first, min(first + run, count));
}
