// From smoothed luminance to tones (paper, section 3.4), with the ink line over them.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 0) const uint FILTERED = 1u;  // 0: no Gaussian, the luminance itself is cut
layout(constant_id = 1) const uint INKED = 1u;     // 0: no line
layout(constant_id = 2) const uint LAYERS = 0u;    // 1: tone and line are kept
layout(constant_id = 3) const int REACH = 1;       // pixels from which a line can reach a pixel
layout(constant_id = 4) const uint HARD = 0u;      // 1: a line of less strength is thinner, not paler
layout(constant_id = 5) const bool SOFT = false;   // the mask
#include "params.glsl"
#include "pixel.glsl"
#include "tile.glsl"
#include "lines.glsl"
#include "toon/ink_width.glsl"
#include "toon/tone.glsl"

layout(std430, binding = 2) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 3) readonly buffer Smooth { float smooth_luminance[]; };
layout(std430, binding = 4) readonly buffer Lines { float lines[]; };
layout(std430, binding = 5) readonly buffer Tones { Tone tones[]; };
layout(std430, binding = 6) writeonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 7) writeonly buffer ToneLayer { vec4 tone_layer[]; };
layout(std430, binding = 8) writeonly buffer OutlineLayer { float outline_layer[]; };

uint pixel_at(ivec2 at) {
    return is_in_picture(uvec2(at)) ? pixels[pixel_index(uvec2(at))] : 0u;
}

float value_at(ivec2 at, uint pixel) {
    return FILTERED != 0u ? smooth_luminance[pixel_index(uvec2(at))] : pixel_luminance(pixel);
}

// Whether smoothed values of pixels may be compared: of the same group; or, as groups change within smooth surfaces where
// the mask is "soft", of the same or the next one: pixels that share a plane of depth. The smoke goes on between them, and so
// does what is smoothed; pixels farther apart have no common surface.
bool is_beside(uint id, uint other) {
    return SOFT ? other != 0u && other <= id + 1u && id <= other + 1u : other == id;
}

// Difference per pixel along an axis between pixels that may be compared: central, one-sided at a border, else 0.
float slope(ivec2 at, ivec2 axis, uint id, float centre) {
    uint next = pixel_at(at + axis);
    uint previous = pixel_at(at - axis);
    bool has_next = is_beside(id, pixel_id(next));
    bool has_previous = is_beside(id, pixel_id(previous));
    float high = has_next ? value_at(at + axis, next) : centre;
    float low = has_previous ? value_at(at - axis, previous) : centre;
    return (high - low) * (has_next && has_previous ? 0.5 : 1.0);
}

vec3 colour_of(uint tone) {
    return vec3(tones[tone].colour[0], tones[tone].colour[1], tones[tone].colour[2]);
}

vec3 tone_of(ivec2 at, uint pixel) {
    float s = value_at(at, pixel);
    float softness = params.tone_softness;
    float width = 0.0;
    if (softness > 0.0) {
        uint id = pixel_id(pixel);
        width = 2.0 * softness * length(vec2(slope(at, ivec2(1, 0), id, s), slope(at, ivec2(0, 1), id, s)));
    }
    vec3 colour = colour_of(0u);
    for (uint i = 1u; i < params.tone_count; ++i) {
        colour = mix(colour, colour_of(i), tone_share(s, tones[i].from, width));
    }
    return colour;
}

float line_at(ivec2 at) {
    return is_in_picture(uvec2(at)) ? lines[pixel_index(uvec2(at))] : 0.0;
}

// Opacity that a line of a strength gives to what is so far from it.
float ink_of(float strength, float width, float way) {
    return HARD != 0u ? ink_share(strength * width, way) : strength * ink_share(width, way);
}

// Opacity of inner lines and of silhouettes, widened: the strongest of the pixels near enough, fading over the last pixel.
vec2 line_of(ivec2 at) {
    vec2 opacity = vec2(0.0);
    for (int y = -REACH; y <= REACH; ++y) {
        for (int x = -REACH; x <= REACH; ++x) {
            float way = length(vec2(x, y));
            float line = line_at(at + ivec2(x, y));
            opacity = max(opacity, vec2(ink_of(max(line, 0.0), params.inner_width, way),
                                        ink_of(max(-line, 0.0), params.silhouette_width, way)));
        }
    }
    return opacity * vec2(1.0, params.silhouette_colour.w);
}

void work_on(uvec2 at) {
    uint index = pixel_index(at);
    uint pixel = pixels[index];
    if (pixel_id(pixel) == 0u) {
        picture[index] = vec4(0.0);
        return;
    }
    vec3 tone = tone_of(ivec2(at), pixel);
    vec2 line = INKED != 0u ? line_of(ivec2(at)) : vec2(0.0);
    // Silhouettes lie over inner lines, which are seen where they are the stronger ones.
    float ink = max(line.x, line.y);
    vec3 colour = params.silhouette_colour.rgb * line.y + params.inner_colour.rgb * (ink - line.y);
    picture[index] = vec4(tone * (1.0 - ink) + colour, 1.0);
    if (LAYERS != 0u) {
        tone_layer[index] = vec4(tone, 1.0);
        outline_layer[index] = ink;
    }
}
