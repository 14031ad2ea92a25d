// A kernel that no GPU likes, for the test that finds such: an array of its own that registers cannot hold.
#version 460
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Darkness { uint values[]; };

void main() {
    uint own[512];
    uint at = gl_GlobalInvocationID.x;
    for (uint i = 0u; i < 512u; ++i) {
        own[i] = values[at + i];
    }
    for (uint i = 0u; i < 512u; ++i) {
        own[own[i] & 511u] += own[511u - i];
    }
    values[at] = own[at & 511u];
}
