// Two triangles a particle over its ember, if it has one. An ember leaves its particle as that cools: it rises and circles, and
// shrinks to nothing. A place is a function of the particle alone, so embers fly as steadily as their particles do.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/limits.glsl"
#include "../common/random.glsl"
#include "../common/view.glsl"
#include "cells.glsl"
#include "fire_tone.glsl"
layout(constant_id = 0) const uint FORM = 0;    // what the entries of the colour table are
layout(constant_id = 1) const uint IS_CEL = 0;  // embers have the colours of tones
layout(std430, binding = 1) readonly buffer Positions { vec4 positions[]; };
layout(std430, binding = 2) readonly buffer Ids { uint ids[]; };
layout(std430, binding = 3) readonly buffer Colours { vec4 colours[]; };
layout(std430, binding = 4) readonly buffer Tones { Tone tones[]; };
layout(location = 0) out Ember {
#include "ember_block.glsl"
} ember;
#include "temperature.glsl"
#include "particle_quad.glsl"
#include "ember_shape.glsl"

const float TURN = 6.2831853;

float drawn(uint id, uint which) {
    return unit(hash(params.seed, id, EMBER_KEY, which));
}

// Of the last tone that is not hotter; the coldest have the first.
vec3 tone_colour(float share) {
    uint tone = 0u;
    for (uint i = 1u; i < params.tone_count; ++i) {
        tone = tones[i].from <= share ? i : tone;
    }
    return vec3(tones[tone].colour[0], tones[tone].colour[1], tones[tone].colour[2]);
}

void main() {
    uint row = particle_row();
    uint id = params.has_ids != 0u ? ids[row] : row;
    vec4 particle = positions[row];
    bool is_place = is_finite(particle.x) && is_finite(particle.y) && is_finite(particle.z) && all(lessThanEqual(abs(particle.xyz), vec3(FARTHEST)));
    bool glows = is_finite(particle.w) && particle.w >= COLDEST;
    ember.middle = vec2(0.0);
    ember.depth = 0.0;
    ember.radius = 0.0;
    ember.light = vec3(0.0);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    if (!is_place || !glows || drawn(id, 0u) >= params.embers) {
        return;
    }
    float t = min(particle.w, params.max_temperature);
    float cooled = params.hottest > COLDEST ? clamp((params.hottest - t) / (params.hottest - COLDEST), 0.0, 1.0) : 0.0;
    float height = params.ember_rise * cooled * (0.5 + drawn(id, 1u));
    float angle = TURN * (drawn(id, 2u) + cooled * (0.5 + drawn(id, 3u)));
    vec3 view = to_view(particle.xyz + height * vec3(ASIDE * cos(angle), 1.0, ASIDE * sin(angle)));
    if (!(view.z >= params.near && view.z <= params.far)) {
        return;
    }
    ember.middle = params.principal_point + params.focal_length * vec2(view.x, -view.y) / widening(view.z);
    ember.depth = view.z;
    ember.radius = params.ember_radius * sqrt(1.0 - cooled);
    float glowing = mix(t, params.hottest, HOTTER);
    ember.light = params.intensity * (IS_CEL != 0u ? tone_colour(glowing / params.hottest) : colour_of(glowing));
    vec2 at = ember.middle + (max(ember.radius, LEAST_RADIUS) + 1.0) * (2.0 * particle_corner() - 1.0);
    gl_Position = vec4(ember.radius > 0.0 ? 2.0 * at / vec2(params.size) - 1.0 : vec2(0.0), 0.0, 1.0);
}
