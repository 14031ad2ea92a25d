// The fire as a lamp for what else is in the scene: where it is on average, how wide, and its colour. One workgroup, always in the same order.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "fire_tone.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) writeonly buffer LampBuffer { Lamp lamp; };
layout(std430, binding = 3) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 4) readonly buffer Tones { Tone tones[]; };
layout(constant_id = 0) const uint CEL = 0;  // 1: particles have the colours of their tones

shared vec4 places[gl_WorkGroupSize.x];   // brightness times position; brightness
shared vec4 colours[gl_WorkGroupSize.x];  // sum of colours; brightness times squared distance

// Of a particle, linear RGB.
vec3 colour_of(vec3 colour) {
    if (CEL == 1u) {
        float heat = colour.r;
        colour = vec3(0.0);
        for (uint i = 0u; i < params.tone_count; ++i) {
            bool reaches = heat >= tones[i].from;
            colour = reaches ? vec3(tones[i].colour[0], tones[i].colour[1], tones[i].colour[2]) : colour;
        }
    }
    return colour;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    // Brightness times a squared distance is to be finite.
    float brightest_of_all = uintBitsToFloat(control.brightest);
    float scale = brightest_of_all > 1e6 ? 1.0 / brightest_of_all : 1.0;
    vec4 place = vec4(0.0);
    vec4 colour = vec4(0.0);
    for (uint row = lane; row < params.particle_count; row += gl_WorkGroupSize.x) {
        float count = particles[row].count == 0u ? 0.0 : float(particles[row].count);
        vec3 own = count * scale * colour_of(particles[row].colour.rgb);
        float brightness = max(own.r, max(own.g, own.b));
        vec3 view = vec3(particles[row].view, particles[row].depth);
        place += brightness > 0.0 ? brightness * vec4(view, 1.0) : vec4(0.0);
        colour += brightness > 0.0 ? vec4(own, brightness * dot(view, view)) : vec4(0.0);
    }
    places[lane] = place;
    colours[lane] = colour;
    barrier();
    if (lane == 0u) {
        for (uint i = 1u; i < gl_WorkGroupSize.x; ++i) {
            place += places[i];
            colour += colours[i];
        }
        vec3 middle = place.xyz / max(place.w, 1e-30);
        float spread = max(colour.w / max(place.w, 1e-30) - dot(middle, middle), 0.0);
        float brightest = max(colour.r, max(colour.g, colour.b));
        // The fire reaches about two standard deviations from its middle.
        vec3 light = params.light * colour.rgb / max(brightest, 1e-30);
        lamp = Lamp(middle.xy, middle.z, max(4.0 * spread, 1e-6), float[](light.r, light.g, light.b), uintBitsToFloat(control.base));
    }
}
