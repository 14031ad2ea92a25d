// Column sums over the row sums of heat, the quotient by all weights in the picture, and from that tones: closed shapes
// that begin where the first tone does, with antialiased borders, and a line along the outermost.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(constant_id = 2) const uint LAYERS = 0u;  // 1: heat, tone and line are kept
#include "params.glsl"
#include "fire_tone.glsl"
#include "toon/tone.glsl"
layout(local_size_x = 128) in;
layout(std430, binding = 1) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 2) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 3) readonly buffer TileShown { uint tile_shown[]; };
layout(std430, binding = 4) readonly buffer Sums { uvec4 sums[]; };
layout(std430, binding = 5) readonly buffer Scene { float scene[]; };
layout(std430, binding = 6) readonly buffer Weights { float weights[]; };
layout(std430, binding = 7) readonly buffer RowSums { vec2 row_sums[]; };
layout(std430, binding = 8) readonly buffer Tones { Tone tones[]; };
layout(std430, binding = 9) writeonly buffer Picture { vec4 picture[]; };
layout(std430, binding = 10) writeonly buffer HeatLayer { vec2 heat_layer[]; };  // smoothed; opacity of the line
layout(std430, binding = 11) writeonly buffer ToneLayer { vec4 tone_layer[]; };
#include "heat.glsl"
#define TAPS 4
#include "toon/gaussian.glsl"
#include "toon/ink_width.glsl"

const uint COLUMNS = TILE + 2u;             // of the tile with the pixels around it, whose differences count
const uint RUNS = TILE / uint(TAPS) + 2u;   // of results in a column of that, which begin at the same rows in all tiles
shared float smoothed[RUNS * uint(TAPS) * COLUMNS];

bool is_inside(ivec2 at) {
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(params.size)));
}

// Sum of the weights of what lies within the picture along an axis of so many pixels.
float weight_of(int at, int count) {
    return weights[0] + weights[params.half_sums + uint(min(params.window, at))] + weights[params.half_sums + uint(min(params.window, count - 1 - at))];
}

// Whether a run of TAPS pixels, all of one tile, has row sums.
bool is_shown(ivec2 first) {
    uvec2 tile = uvec2(first) / TILE;
    return is_inside(first) && tile_shown[tile.y * params.tiles.x + tile.x] != 0u;
}

// Smoothed heat of TAPS pixels of a column, from row `first` on.
float[TAPS] smooth_run(int x, int first) {
    float heat[TAPS];
    float seen[TAPS];
    for (int o = 0; o < TAPS; ++o) {
        heat[o] = 0.0;
        seen[o] = 0.0;
    }
    for (int distance = (params.window + TAPS - 1 + TAPS - 1) / TAPS; distance >= 0; --distance) {
        float ahead[2 * TAPS - 1] = tap_weights(distance);
        for (int side = -1; side <= 1; side += 2) {
            int begin = first + side * distance * TAPS;
            // Rows of other tiles have no heat; and all rows that count where there is some are shown.
            if ((distance > 0 || side > 0) && is_shown(ivec2(x, begin))) {
                float values[TAPS];
                float masks[TAPS];
                for (int t = 0; t < TAPS; ++t) {
                    ivec2 at = ivec2(x, begin + t);
                    vec2 row = vec2(0.0);
                    if (is_inside(at)) {
                        row = row_sums[pixel_index(uvec2(at))];
                    }
                    values[t] = row.x;
                    masks[t] = row.y;
                }
                float w[2 * TAPS - 1] = on_side(ahead, side);
                add_values(heat, w, values);
                if (HAS_SCENE == 1u) {
                    add_values(seen, w, masks);
                }
            }
        }
    }
    for (int o = 0; o < TAPS; ++o) {
        ivec2 at = ivec2(x, first + o);
        if (is_inside(at)) {
            float all_weights = weight_of(at.x, int(params.size.x)) * weight_of(at.y, int(params.size.y));
            heat[o] /= HAS_SCENE == 1u ? max(seen[o], 1e-30) : all_weights;
        }
    }
    return heat;
}

float smoothed_at(uvec2 own, int x, int y) {
    return smoothed[uint(int(own.y) + TAPS + y) * COLUMNS + uint(int(own.x) + 1 + x)];
}

// How much heat changes from pixel to pixel: differences are central, and one-sided at the picture's border.
float slope_of(uvec2 own, ivec2 at) {
    vec2 slope;
    for (int axis = 0; axis < 2; ++axis) {
        ivec2 way = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
        ivec2 high = is_inside(at + way) ? way : ivec2(0);
        ivec2 low = is_inside(at - way) ? -way : ivec2(0);
        float rise = smoothed_at(own, high.x, high.y) - smoothed_at(own, low.x, low.y);
        slope[axis] = rise * (high != ivec2(0) && low != ivec2(0) ? 0.5 : 1.0);
    }
    return length(slope);
}

vec3 colour_of(uint tone) {
    return params.intensity * vec3(tones[tone].colour[0], tones[tone].colour[1], tones[tone].colour[2]);
}

// Linear RGB of a pixel's tones; a: share of the pixel that the fire has.
vec4 tone_of(float heat, float slope) {
    float width = 2.0 * params.tone_softness * slope;
    vec3 colour = colour_of(0u);
    for (uint i = 1u; i < params.tone_count; ++i) {
        colour = mix(colour, colour_of(i), tone_share(heat, tones[i].from, width));
    }
    return vec4(colour, tone_share(heat, tones[0].from, width));
}

void work_on(uvec2 own, ivec2 at, bool has_fire) {
    uint index = pixel_index(uvec2(at));
    float heat = smoothed_at(own, 0, 0);
    bool hidden = false;
    if (HAS_SCENE == 1u) {
        hidden = is_hidden(index, has_fire);
    }
    float slope = slope_of(own, at);
    vec4 tone = hidden ? vec4(0.0) : tone_of(heat, slope);
    // How far it is from the silhouette, as the slope says: far within the fire, where that is 0.
    float above = heat - tones[0].from;
    float way = above > params.ink_width * slope ? params.ink_width : max(above / max(slope, 1e-30), 0.0);
    float ink = params.ink.w * ink_share(params.ink_width, way);
    picture[index] = vec4(mix(tone.rgb, params.ink.rgb, ink), 1.0) * tone.a;
    if (LAYERS == 1u) {
        heat_layer[index] = vec2(heat, ink * tone.a);
        tone_layer[index] = vec4(tone.rgb, 1.0) * tone.a;
    }
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint index = occupied_tiles[gl_WorkGroupID.x];
    ivec2 corner = ivec2(tile_at(index) * TILE);
    for (uint run = lane; run < RUNS * COLUMNS; run += gl_WorkGroupSize.x) {
        uint x = run % COLUMNS;
        uint first = run / COLUMNS * uint(TAPS);
        float heat[TAPS] = smooth_run(corner.x - 1 + int(x), corner.y - TAPS + int(first));
        for (uint o = 0u; o < uint(TAPS); ++o) {
            smoothed[(first + o) * COLUMNS + x] = heat[o];
        }
    }
    barrier();
    bool has_fire = (tile_shown[index] & BURNING) != 0u;
    for (uint i = lane; i < TILE * TILE; i += gl_WorkGroupSize.x) {
        uvec2 own = uvec2(i % TILE, i / TILE);
        ivec2 at = corner + ivec2(own);
        if (is_inside(at)) {
            work_on(own, at, has_fire);
        }
    }
}
