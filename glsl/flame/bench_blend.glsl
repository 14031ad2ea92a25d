// Particles as the fog that blending takes them for: each at the one depth of its centre, of opacity 1 - (1 - Q)^n at a pixel. A workgroup
// is a tile; what touches each of its blocks is a set of bits.
#include "params.glsl"
const uint TILE_PIXELS = TILE * TILE;
layout(local_size_x = TILE_PIXELS) in;
layout(std430, binding = 1) readonly buffer Particles { Particle particles[]; };
layout(std430, binding = 2) readonly buffer ControlBuffer { Control control; };
layout(std430, binding = 3) readonly buffer Cells { uint cell_ends[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(std430, binding = 5) readonly buffer OccupiedTiles { uint occupied_tiles[]; };
layout(std430, binding = 6) readonly buffer FarTable { float far_table[]; };
layout(std430, binding = 7) writeonly buffer Blended { vec4 blended[]; };
#include "bins.glsl"
#include "cells.glsl"
#include "depth_range.glsl"
#include "kernel.glsl"
#include "lists.glsl"

const uint PRESENT_WORDS = TILE_PIXELS;          // of a set of particles: an invocation clears one
const uint PRESENT_BITS = 32u * PRESENT_WORDS;  // as many particles as the benchmark has at most

shared uint present[BLOCKS][PRESENT_WORDS];

struct Pixel {
    uint at;
    uint block;
    bool inside;
    vec2 ray;
};

uvec2 own_tile() {
    return tile_at(occupied_tiles[gl_WorkGroupID.x]);
}

// Invocations 64 b .. 64 b + 63 are block b, so that those that run together meet the same particles.
Pixel own_pixel() {
    uint lane = gl_LocalInvocationID.x;
    Pixel pixel;
    pixel.block = lane / (BLOCK * BLOCK);
    uvec2 place = uvec2(lane % BLOCK, lane / BLOCK % BLOCK);
    uvec2 at = own_tile() * TILE + block_corner(pixel.block) + place;
    pixel.at = pixel_index(at);
    pixel.inside = all(lessThan(at, params.size));
    pixel.ray = ray_at(vec2(at) + 0.5);
    return pixel;
}

void clear_present() {
    [[unroll]] for (uint block = 0u; block < BLOCKS; ++block) {
        present[block][gl_LocalInvocationID.x] = 0u;
    }
    barrier();
}

// Notes a particle as number `index` in the blocks that it touches.
void note(uint row, uint index) {
    vec4 bounds = pixel_bounds(from_eye(vec3(particles[row].view, particles[row].depth)), 1.0, vec2(1.0)) - vec2(own_tile() * TILE).xyxy;
    [[unroll]] for (uint block = 0u; block < BLOCKS; ++block) {
        vec2 low = vec2(block_corner(block));
        if (all(lessThanEqual(bounds.xy, low + float(BLOCK))) && all(greaterThanEqual(bounds.zw, low))) {
            atomicOr(present[block][index / 32u], 1u << (index & 31u));
        }
    }
}

// Notes the tile's particles, each as its row.
void note_rows() {
    clear_present();
    for (uint level = 0u; level < params.cell_level_count; ++level) {
        uvec2 list = list_range(own_tile(), level);
        for (uint at = list.x + gl_LocalInvocationID.x; at < list.y; at += TILE_PIXELS) {
            note(entries[at], entries[at]);
        }
    }
    barrier();
}

float far_at(ivec2 place, int class_index) {
    return far_table[place.x + int(KERNEL_PLACES) * (place.y + int(KERNEL_PLACES) * class_index)];
}

// -ln(1 - opacity) of a particle at a pixel's ray.
float absorbance(uint row, vec2 ray) {
    vec3 view = from_eye(vec3(particles[row].view, particles[row].depth));
    int class_index = int(particles[row].class_index);
    float reach = kernel_reach();
    float narrow = min(reach / max(NARROW * params.pixel_footprint * widening(view.z), 1e-30), 1.0) / reach;
    vec2 offset = view.z * ray - view.xy;
    vec2 place = (vec2(offset.x, -offset.y) * narrow * 0.5 + 0.5) * LAST_PLACE;
    bool inside = all(greaterThanEqual(place, vec2(0.0))) && all(lessThanEqual(place, vec2(LAST_PLACE)));
    place = clamp(place, 0.0, LAST_PLACE);
    ivec2 low = ivec2(min(place, vec2(LAST_PLACE - 0.001)));
    vec2 f = place - vec2(low);
    float above = mix(far_at(low, class_index), far_at(low + ivec2(1, 0), class_index), f.x);
    float below = mix(far_at(low + ivec2(0, 1), class_index), far_at(low + ivec2(1, 1), class_index), f.x);
    return inside ? -particles[row].weight * mix(above, below, f.y) : 0.0;
}

// Colour of a particle at a pixel's ray, and its opacity there.
vec4 fog(uint row, vec2 ray) {
    return vec4(particles[row].colour.rgb, opacity(absorbance(row, ray)));
}
