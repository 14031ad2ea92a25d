// What the host tells every flame kernel, and what kernels tell each other. `src/flame/params.rs` has the same
// structures; build.rs compares offsets and sizes.
#ifndef FLAME_PARAMS
#define FLAME_PARAMS

#extension GL_GOOGLE_include_directive : require

#include "common/bits.glsl"

const uint TILE = 16u;          // side of a screen tile in pixels
const uint BLOCK = 8u;          // side of a block in pixels; a tile is 2 x 2 blocks
const uint CELLS_ACROSS = 4u;   // a particle stands at the level of cells where it touches at most so many across
const uint MASK_SIDE = 64u;     // texels of the mask along a side
const uint MASK_LEVELS = 7u;

layout(binding = 0) uniform FlameParams {
    vec4 eye;          // position of the camera, high part; w: unused
    vec4 eye_low;      // what `eye` lost in rounding
    vec4 right;        // rows of the view rotation
    vec4 up;
    vec4 forward;
    vec4 right_low;    // what they lost in rounding
    vec4 up_low;
    vec4 forward_low;
    vec4 lens;         // half extent at depth 1 along x and y, near, far
    vec4 focal;        // pixels of a slope of 1, the picture's centre in pixels x, y; 1 / pixels of a slope of 1
    uvec4 image;       // width, height, tiles across, tiles down
    uvec4 counts;      // particles, depth buckets, levels of cells, unused
    uvec4 draw;        // seed, variants of the mask, how far draws have flickered on: whole, 16-bit fraction
    uvec4 flags;       // 1 if what is not needed is left out; bits of the Sobol index; repetitions done before; 1 if sprites are sized in pixels, 2 if there are ids
    vec4 model;        // alpha scale, threshold, count, hottest temperature of the settings
    vec4 space;        // spread, side of a sprite (metres or pixels), how far render particles go in depth, temperature that particles clamp to
    vec4 light;        // intensity, largest value of the mask, bound of the 95 % interval, tint of smoke
    vec4 colour;       // colour table: places a unit of T or 1 / T, place of 0, last place, fall-off
    vec4 shift;        // what its logarithms are of more than the colour
    uvec4 levels[12];  // cells of each level: first, across, down
} params;

// What the device decides during a frame; the host resets it at the frame's start.
struct Control {
    uint brightest;        // bits of the largest component of any particle's colour
    uint nearest;          // bits of the smallest view depth of a particle ahead of the near plane
    uint range_low;        // depth range of what can be seen, ordered bits
    uint range_high;
    uint visible;          // particles that can be seen
    uint most;             // most render particles of one of them
    uint segments;         // parts that a tile's list is cut into
    uint segment_entries;  // entries of each
    uint part_repetitions; // repetitions of a dispatch
    uint listed;           // entries of the longest list that a tile can have
    uint classes;          // of the kernel table: a bit for each that a particle needs
    uint new_classes;      // those of them that the table does not have
    uint base;             // bits of the view depth that particles' depths are less; 0 unless the fire is far away
    uint depth_low;        // depth range of what can be seen from there, if it is not 0
    uint depth_high;
    uint unused;
    uvec4 tile_groups;     // dispatch over occupied tiles
    uvec4 active_groups;   // dispatch over tiles that need more repetitions
    uvec4 tile_draw;       // draw of occupied tiles
    uvec4 share_groups;    // dispatches that make the kernel table anew
    uvec4 kernel_groups;
    uvec4 screen_draw;     // draw of the whole picture
    uvec4 sprite_draw;     // draw of all sprites of a repetition
};

// A physical particle in a frame.
struct Particle {
    vec4 view;      // centre in view space, z less the frame's base; w: alpha where the mask is 1
    vec4 centre;    // centre in pixels: whole and fraction of x, whole and fraction of y
    vec4 slope;     // x / z and y / z of the centre; 1 if it is too near the camera for these; share of its square that matters
    vec4 colour;    // linear RGB; w: mean number of render particles
    uvec4 draw;     // hash of its id, id, number of render particles (0: dropped), class of the kernel table; until `range` bits of what z has lost in rounding
    uvec4 light;    // colour in 65535ths of the brightest: r | g << 16, b; weight of its class; 1 if it is in lists, until `weigh` has how often a sprite below a pixel passes there
};

// The fire as a lamp, in view space.
struct Lamp {
    vec4 place;   // middle, z less the frame's base; square of its width
    vec4 colour;  // how much it brightens what is close to it; the frame's base
};

#endif
