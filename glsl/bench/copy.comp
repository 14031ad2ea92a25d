// What the device can move: reads and writes each word once.
#version 460
layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer From { vec4 from_words[]; };
layout(std430, binding = 1) writeonly buffer To { vec4 to_words[]; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < uint(to_words.length())) {
        to_words[index] = from_words[index];
    }
}
