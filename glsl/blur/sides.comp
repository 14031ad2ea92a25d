// What the two frames show of what pixels' centres see, for reading after the frame.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "params.glsl"
#include "samples.glsl"
layout(local_size_x = TILE, local_size_y = TILE) in;
#include "seeing.glsl"
#include "fragment.glsl"
layout(binding = 18) uniform utexture2D distorted;
layout(std430, binding = 19) writeonly buffer PreviousLayer { vec4 previous_layer[]; };
layout(std430, binding = 20) writeonly buffer NextLayer { vec4 next_layer[]; };
layout(std430, binding = 21) writeonly buffer SubframeLayer { float subframe_layer[]; };
layout(std430, binding = 22) writeonly buffer MaskLayer { uint mask_layer[]; };

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!is_in_picture(at)) {
        return;
    }
    uint index = index_of(at);
    uint triangle_id = texelFetch(distorted, at, 0).x;
    vec4 colours[2] = vec4[2](vec4(0.0), vec4(0.0));
    uint mask = NOTHING_SEEN;
    float moved = 1.0;
    if (triangle_id > 0u) {
        Fragment fragment = fragment_at(triangle_id, vec2(at) + 0.5);
        mask = 0u;
        moved = fragment.moved;
        for (uint side = 0u; side < 2u; ++side) {
            float weight;
            look(1u + side, fragment.base, fragment.barycentrics, colours[side], weight);
            mask |= weight > LEAST_WEIGHT ? 1u << side : 0u;
        }
    }
    previous_layer[index] = (mask & SHOWN_PREVIOUS) != 0u ? colours[0] : vec4(0.0);
    next_layer[index] = (mask & SHOWN_NEXT) != 0u ? colours[1] : vec4(0.0);
    subframe_layer[index] = moved;
    mask_layer[index] = mask;
}
