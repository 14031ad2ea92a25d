// What the host tells every flame kernel, and what kernels tell each other. build.rs writes the same for Rust.
#ifndef FLAME_PARAMS
#define FLAME_PARAMS

#extension GL_GOOGLE_include_directive : require

#include "common/bits.glsl"
#include "common/camera.glsl"

const uint TILE = 16u;          // side of a screen tile in pixels
const uint BLOCK = 8u;          // side of a block in pixels; a tile is 2 x 2 blocks
const uint BLOCKS = TILE * TILE / BLOCK / BLOCK;  // of a tile
const uint CELLS_ACROSS = 4u;   // a particle stands at the level of cells where it touches at most so many across
const uint MAX_CELL_LEVELS = 12u;

const uint MASK_SIDE = 64u;     // texels of the mask along a side
const uint MASK_LEVELS = 7u;
const float NOISE_CELLS = 4.0;  // of the mask's noise, across a sprite

const uint MOST_OCTAVES = 8u;   // of finer noise
const float FIRST_OCTAVE = 4.0; // texels of the first of them from wave to wave; each next has half
const float OCTAVE = 0.7;       // alpha of an octave, where the mask would be 1 without noise

const float COLDEST = 700.0;        // what is colder emits nothing, in kelvin
const float MOST_COUNT = 32768.0;   // render particles of a particle in a repetition
const float LIGHT_STEPS = 65535.0;  // of a colour's component, up to the brightest of the frame

const uint COUNT_KEY = 0xffffffffu;  // keys of draws that are no repetition's: the fraction of a count,
const uint PHASE_KEY = 0xffffffffu;  // when the flicker renews a render particle,
const uint SOBOL_KEY = 0xfffffffeu;  // its Sobol sequence
const uint OCTAVE_KEY = 0xfffffffdu; // the finer noise of a variant of the mask
const uint EMBER_KEY = 0xfffffffcu;  // an ember's draws
const uint RENEWAL = 0x9e3779b9u;    // what is added to the words of a draw that is renewed

const uint NOTHING = 0xffffffffu;  // the minimum of no numbers

const uint NEAR_CAMERA = 1u;  // flags of a particle: too near the camera for slopes
const uint LISTED = 2u;       // it is in the lists of cells

const uint RADIANCE = 0u;      // what the entries of the colour table are, as `flame::colour::Form` says
const uint CHROMATICITY = 1u;
const uint RAMP = 2u;

const uint SUM_VECTORS = 4u;         // of a pixel's sums: vectors of four words
const uint UNFINISHED_VECTORS = 2u;  // of a bin of the expected image that is not finished
const uint UNLAID_VECTORS = 3u;      // of its last two bins, between dispatches; one more with layers

const uint SHOWN = 1u;    // of a tile: heat or light may reach it,
const uint BURNING = 2u;  // it has fire

const uint QUAD_VERTICES = 4u;
const uint PARTICLE_VERTICES = 6u;  // of two triangles

// A level of the screen's cells.
struct CellLevel {
    uint first;   // its first cell among those of all levels
    uint across;  // cells
    uint down;
    uint end;     // the cell after its last
};

layout(binding = 0) uniform FlameParams {
    CameraRows camera;
    float near;               // view depths that are seen, in metres
    float far;
    vec2 focal_length;        // pixels of a slope of 1 to the right and up; orthographic: of a metre
    vec2 pixel_slope;         // 1 / focal_length
    vec2 principal_point;     // where a slope of 0 is seen, in pixels
    vec2 depth_terms;         // of the host's depth images
    uint is_orthographic;
    float pixel_footprint;    // the wider side of a pixel at a depth of 1, in metres; orthographic: at any depth
    float squash;             // pixels of a sprite across over those down
    uvec2 size;               // of the picture in pixels
    uvec2 corner;             // of the picture, in the target
    uvec2 tiles;              // across and down
    uint cell_count;          // cells of all levels
    uint cell_level_count;
    uint bucket_count;        // depth buckets of a cell
    uint iterations;          // repetitions, or depth bins of the expected image
    uint repetitions_before;  // that earlier frames have added
    uint particle_count;
    uint seed;
    uint variants;            // of the mask
    uint sobol_bits;          // bits of the index into the Sobol sequence
    uint flicker_whole;       // how often all draws have been renewed
    uint flicker_fraction;    // and what is left over, in 65536ths
    uint is_skipping;         // what is not needed is left out
    uint is_in_pixels;        // the unit of `sprite_size`: metres if 0
    uint has_ids;             // a particle's id is its row if 0
    float sprite_size;        // side of a sprite
    float spread;             // radius of the ball, or half side of the cube, of a particle's render particles, in metres
    float bounding_radius;    // of what they fill, in metres
    float relative_size;      // side of a sprite in spreads; 0 without a spread
    float slabs;              // of depth, a metre: in each the hottest sprite gives the colour; 0: the nearest does
    float alpha_scale;
    float threshold;
    float count;              // mean number of render particles of a particle at `hottest`
    float hottest;            // kelvin
    float max_temperature;    // hotter particles count as this hot, in kelvin
    float max_alpha;          // largest value of the mask
    float intensity;
    float adaptive;           // widest 95 % interval of a pixel that is good enough
    float light;
    float stretch;            // sprites are drawn out along their way of so many seconds
    uint has_velocities;
    float falloff;
    float table_scale;        // colour table: places a unit of T or 1 / T
    float table_offset;       // place of 0
    float table_last;         // last place
    float tone_softness;      // of the look "cel": half the width of borders between tones, in pixels
    uint tone_count;
    int window;               // of the Gaussian, in pixels to each side
    uint half_sums;           // place of the sums of its weights, from distance 1 on, behind those
    float ink_width;          // of the line, in pixels
    int glow_window;          // of the glow's Gaussian, in pixels to each side
    float glow;               // its strength, over the sum of all weights
    float embers;             // share of the particles that have one
    float ember_radius;       // of the hottest, in pixels
    float ember_rise;         // how far above its particle one is that has cooled, in metres
    vec4 ink;                 // its linear RGB; w: its opacity
    vec4 table_shift;         // what its logarithms are of more than the colour; w: unused
    CellLevel cell_levels[MAX_CELL_LEVELS];
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
    uint listed;           // entries of the tile that has most in its lists
    uint classes;          // of the kernel table: a bit for each that a particle needs
    uint base;             // bits of the view depth that particles' depths are less; 0 unless the fire is far away
    uint depth_low;        // depth range of what can be seen from there, if it is not 0
    uint depth_high;
    uint unused[2];
    uvec4 tile_groups;     // dispatch over occupied tiles
    uvec4 active_groups;   // dispatch over tiles that need more repetitions
    uvec4 tile_draw;       // draw of occupied tiles
    uvec4 screen_draw;     // draw of the whole picture
    uvec4 sprite_draw;     // draw of all sprites of a repetition
};

// The kernel table on the device, and what is made of it anew.
struct KernelTable {
    uvec4 share_groups;   // dispatches that make it
    uvec4 kernel_groups;
    uint level;           // of the mask that it is of
    uint classes;         // that it has: a bit each
    uint new_classes;     // those of them that are new
    uint unused;
};

// A physical particle in a frame.
struct Particle {
    vec2 view;            // centre in view space in metres, x right, y up
    float depth;          // its view depth, less the frame's base
    float mean_count;     // mean number of render particles
    vec2 pixel;           // centre in pixels: whole ones
    vec2 pixel_fraction;  // and the rest
    vec2 slope;           // x / z and y / z of the centre; 0 if it is near the camera, or rays are parallel
    float reach;          // share of its sprites' half side that can pass
    uint flags;           // NEAR_CAMERA, LISTED
    vec4 colour;          // linear RGB; alpha where the mask is 1
    uint hash;            // of its id
    uint id;
    uint count;           // render particles; 0: dropped
    uint class_index;     // of the kernel table
    uvec2 light;          // colour in LIGHT_STEPS of the brightest: r | g << 16, b
    float weight;         // of its class; until `range` what `depth` has lost in rounding
    float chance;         // how often a sprite below a pixel passes there
};

// The fire as a lamp, in view space.
struct Lamp {
    vec2 middle;          // metres, x right, y up
    float depth;          // of the middle, less `base`
    float squared_width;
    float colour[3];      // how much it brightens what is close to it: linear RGB
    float base;           // the frame's
};

uvec2 tile_at(uint index) {
    return uvec2(index % params.tiles.x, index / params.tiles.x);
}

// Where a block's first pixel lies in its tile.
uvec2 block_corner(uint block) {
    return BLOCK * uvec2(block & 1u, block >> 1u);
}

uint pixel_index(uvec2 pixel) {
    return pixel.y * params.size.x + pixel.x;
}

#include "common/widening.glsl"

// Slope of what is seen at a place of the picture, in pixels.
vec2 ray_at(vec2 place) {
    vec2 slope = (place - params.principal_point) * params.pixel_slope;
    return vec2(slope.x, -slope.y);
}

#endif
