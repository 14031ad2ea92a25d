// From smoothed luminance to tones (paper, section 3.4), with the ink line over them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "no_channel.glsl"
layout(constant_id = 0) const uint FILTERED = 1u;  // 0: no Gaussian, the luminance itself is cut
layout(constant_id = 1) const uint INKED = 1u;     // 0: no line
layout(constant_id = 2) const uint LAYERS = 0u;    // 1: tone and line are kept
layout(constant_id = 3) const int REACH = 1;       // pixels from which a line can reach a pixel
layout(constant_id = 4) const uint HARD = 0u;      // 1: a line of less strength is thinner, not paler
layout(constant_id = 5) const bool SOFT = false;   // the mask
layout(constant_id = 6) const bool SHADED = false;    // tones have other colours in shadow
layout(constant_id = 7) const bool GRADIENT = false;  // tones are others higher up
layout(constant_id = 8) const uint SHADE = NO_CHANNEL;         // channel of the share of the light that arrives,
layout(constant_id = 9) const uint FIRE = NO_CHANNEL;          // of the fire's light,
layout(constant_id = 10) const uint RIM = NO_CHANNEL;     // of how far surfaces are turned away, where there may be a rim
layout(constant_id = 11) const bool ANTIALIASED = false;  // smoke covers pixels in part
#include "params.glsl"
#include "pixel.glsl"
#include "tile.glsl"
#include "lines.glsl"
#include "channels.glsl"
#include "view.glsl"
#include "toon/ink_width.glsl"
#include "toon/luminance.glsl"
#include "toon/tone.glsl"

// From luminance `from` upwards the smoke has this colour.
struct Tone {
    float colour[3];  // linear RGB
    float from;
    float shadow[3];  // the colour where a shadow falls
    float unused;
};

layout(std430, binding = 2) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 3) readonly buffer Smooth { float smooth_luminance[]; };
layout(std430, binding = 4) readonly buffer Lines { float lines[]; };
layout(std430, binding = 5) readonly buffer Tones { Tone tones[]; };
layout(std430, binding = 6) writeonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 7) writeonly buffer ToneLayer { vec4 tone_layer[]; };
layout(std430, binding = 8) writeonly buffer OverlayLayer { vec4 overlay_layer[]; };
layout(std430, binding = 9) readonly buffer Channels { float channels[]; };
layout(std430, binding = 10) readonly buffer SmoothChannels { float smooth_channels[]; };
layout(std430, binding = 11) readonly buffer ViewSpheres { vec4 view_spheres[]; };
layout(std430, binding = 12) writeonly buffer MatteLayer { vec4 matte_layer[]; };
layout(binding = 13, r32ui) uniform readonly uimage2D seen;
#include "coverage.glsl"

const uint LUMINANCE = NO_CHANNEL;

// A smoothed value, and over how much of it a border is drawn.
struct Smoothed {
    float value;
    float width;
};

uint pixel_at(ivec2 at) {
    return is_in_picture(uvec2(at)) ? pixels[pixel_index(uvec2(at))] : 0u;
}

float channel_at(uint channel, uint index) {
    return FILTERED != 0u ? smooth_channels[channel_index(channel, index)] : channels[channel_index(channel, index)];
}

// Luminance without the rim.
float plain_luminance(uint index, uint pixel) {
    return FILTERED != 0u ? smooth_luminance[index] : pixel_luminance(pixel);
}

float value_at(uint channel, ivec2 at, uint pixel) {
    uint index = pixel_index(uvec2(at));
    if (channel != NO_CHANNEL) {
        return channel_at(channel, index);
    }
    float luminance = plain_luminance(index, pixel);
    return RIM != NO_CHANNEL ? with_rim(luminance, channel_at(RIM, index), params.rim) : luminance;
}

// Whether smoothed values of pixels may be compared: of the same group; or, as groups change within smooth surfaces where
// the mask is "soft", of the same or the next one: pixels that share a plane of depth. The smoke goes on between them, and so
// does what is smoothed; pixels farther apart have no common surface.
bool is_beside(uint id, uint other) {
    return SOFT ? other != 0u && other <= id + 1u && id <= other + 1u : other == id;
}

// Difference per pixel along an axis between pixels that may be compared: central, one-sided at a border, else 0.
float slope(uint channel, ivec2 at, ivec2 axis, uint id, float centre) {
    uint next = pixel_at(at + axis);
    uint previous = pixel_at(at - axis);
    bool has_next = is_beside(id, pixel_id(next));
    bool has_previous = is_beside(id, pixel_id(previous));
    float high = has_next ? value_at(channel, at + axis, next) : centre;
    float low = has_previous ? value_at(channel, at - axis, previous) : centre;
    return (high - low) * (has_next && has_previous ? 0.5 : 1.0);
}

Smoothed smoothed_at(uint channel, ivec2 at, uint pixel) {
    float s = value_at(channel, at, pixel);
    float softness = params.tone_softness;
    float width = 0.0;
    if (softness > 0.0) {
        uint id = pixel_id(pixel);
        float across = slope(channel, at, ivec2(1, 0), id, s);
        width = 2.0 * softness * length(vec2(across, slope(channel, at, ivec2(0, 1), id, s)));
    }
    return Smoothed(s, width);
}

// Share of the pixel where the value is at least `from`.
float share_from(Smoothed s, float from) {
    return tone_share(s.value, from, s.width);
}

// A tone where a share of the pixel is out of shadow.
vec3 colour_of(uint tone, float unshaded) {
    vec3 colour = vec3(tones[tone].colour[0], tones[tone].colour[1], tones[tone].colour[2]);
    if (SHADED) {
        vec3 shadow = vec3(tones[tone].shadow[0], tones[tone].shadow[1], tones[tone].shadow[2]);
        colour = mix(shadow, colour, unshaded);
    }
    return colour;
}

// What luminance becomes by `count` of the tones.
vec3 tone_of(Smoothed luminance, float unshaded, uint first, uint count) {
    vec3 colour = colour_of(first, unshaded);
    for (uint i = first + 1u; i < first + count; ++i) {
        colour = mix(colour, colour_of(i, unshaded), share_from(luminance, tones[i].from));
    }
    return colour;
}

// How far the colours have changed to those higher up.
float gradient_at(uvec2 at) {
    Ray ray = pixel_ray(vec2(at) + 0.5);
    float depth;
    vec3 normal;
    hit_sphere(ray, view_spheres[(imageLoad(seen, ivec2(at)).x >> GROUP_BITS) - 1u], depth, normal);
    float height = dot(params.height.xyz, ray.from + depth * ray.way) + params.height.w;
    return params.gradient_height > 0.0 ? clamp(height / params.gradient_height, 0.0, 1.0) : height >= 0.0 ? 1.0 : 0.0;
}

// Share of its brightness that the fire's light has where it is rounded to as many even steps as there are tones.
float fire_steps(Smoothed fire) {
    float sum = 0.0;
    for (uint i = 1u; i < params.tone_count; ++i) {
        sum += share_from(fire, (float(i) - 0.5) / float(params.tone_count));
    }
    return sum / max(float(params.tone_count) - 1.0, 1.0);
}

// Shares of the pixel of the first three tones, and of the others together.
vec4 mattes_of(Smoothed luminance) {
    vec4 mattes = vec4(1.0, 0.0, 0.0, 0.0);
    for (uint i = 1u; i < params.tone_count; ++i) {
        float share = share_from(luminance, tones[i].from);
        mattes = mix(mattes, vec4(equal(uvec4(0u, 1u, 2u, 3u), uvec4(min(i, 3u)))), share);
    }
    return mattes;
}

// Share of the pixel whose tone is a higher one because of the rim, without which its luminance is `plain`.
float rim_matte(Smoothed luminance, float plain) {
    Smoothed without = Smoothed(plain, luminance.width);
    float risen = 0.0;
    for (uint i = 1u; i < params.tone_count; ++i) {
        risen += share_from(luminance, tones[i].from) - share_from(without, tones[i].from);
    }
    return clamp(risen, 0.0, 1.0);
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
    ivec2 source = ivec2(at);
    float coverage = ANTIALIASED ? coverage_of(ivec2(at), source) : 1.0;
    uint pixel = pixel_at(source);
    if (pixel_id(pixel) == 0u) {
        picture[index] = vec4(0.0);
        return;
    }
    Smoothed luminance = smoothed_at(LUMINANCE, source, pixel);
    float unshaded = SHADE != NO_CHANNEL ? share_from(smoothed_at(SHADE, source, pixel), 0.5) : 1.0;
    vec3 tone = tone_of(luminance, unshaded, 0u, params.tone_count);
    vec3 lightest = colour_of(params.tone_count - 1u, 1.0);
    if (GRADIENT) {
        uint above = params.tone_count + params.tones_above;
        float share = gradient_at(uvec2(source));
        tone = mix(tone, tone_of(luminance, unshaded, params.tone_count, params.tones_above), share);
        lightest = mix(lightest, colour_of(above - 1u, 1.0), share);
    }
    if (FIRE != NO_CHANNEL) {
        tone += params.fire_colour.rgb * lightest * fire_steps(smoothed_at(FIRE, source, pixel));
    }
    vec2 line = INKED != 0u ? line_of(source) : vec2(0.0);
    // Silhouettes lie over inner lines, which are seen where they are the stronger ones.
    float ink = max(line.x, line.y);
    vec3 colour = params.silhouette_colour.rgb * line.y + params.inner_colour.rgb * (ink - line.y);
    picture[index] = coverage * vec4(tone * (1.0 - ink) + colour, 1.0);
    if (LAYERS != 0u) {
        tone_layer[index] = coverage * vec4(tone, 1.0);
        matte_layer[index] = coverage * mattes_of(luminance);
        float plain = plain_luminance(pixel_index(uvec2(source)), pixel);
        float rim = RIM != NO_CHANNEL ? rim_matte(luminance, plain) : 0.0;
        overlay_layer[index] = coverage * vec4(ink, line.y, 1.0 - unshaded, rim);
    }
}
