// What the device can compute: sixteen independent chains of multiply-add in registers.
#version 460
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Results { float results[]; };
layout(constant_id = 0) const uint ITERATIONS = 1024u;

void main() {
    float start = float(gl_GlobalInvocationID.x) * 1e-9;
    float chains[16];
    for (int i = 0; i < 16; ++i) {
        chains[i] = start + float(i);
    }
    for (uint iteration = 0u; iteration < ITERATIONS; ++iteration) {
        // Written out: a loop of its own would be paid for, too. The values stay finite.
        #define STEP(i) chains[i] = chains[i] * 0.99951 + 0.00049;
        STEP(0) STEP(1) STEP(2) STEP(3) STEP(4) STEP(5) STEP(6) STEP(7)
        STEP(8) STEP(9) STEP(10) STEP(11) STEP(12) STEP(13) STEP(14) STEP(15)
    }
    float sum = 0.0;
    for (int i = 0; i < 16; ++i) {
        sum += chains[i];
    }
    if (gl_GlobalInvocationID.x < uint(results.length())) {
        results[gl_GlobalInvocationID.x] = sum;
    }
}
