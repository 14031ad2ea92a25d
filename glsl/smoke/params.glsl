// What the host tells every smoke kernel, and what kernels tell each other. `src/smoke/params.rs` has the same
// structures; build.rs compares offsets and sizes.
#ifndef SMOKE_PARAMS
#define SMOKE_PARAMS

#extension GL_GOOGLE_include_directive : require

#include "common/bits.glsl"

const uint TILE = 32u;           // side of a screen tile in pixels
const uint BLOCK = 8u;           // side of a block in pixels; a tile is 4 x 4 blocks
const uint TILE_BLOCKS = 4u;
const uint SLOT_PIXELS = 1024u;  // pixels of a tile
const uint BIRTH_BLOCK = 256u;   // words of occupancy whose births are counted together
const uint LIST_RUN = 16u;       // sphere slots that one invocation counts and lists

layout(binding = 0) uniform SmokeParams {
    vec4 eye;          // position of the camera, high part; w: unused
    vec4 eye_low;      // what `eye` lost in rounding
    vec4 right;        // rows of the view rotation
    vec4 up;
    vec4 forward;
    vec4 right_low;    // what they lost in rounding
    vec4 up_low;
    vec4 forward_low;
    vec4 lens;         // half extent at depth 1 along x and y, near, far
    uvec4 image;       // width, height, tiles across, tiles down
    uvec4 grid;        // voxels along x, y, z; words a row
    vec4 voxel;        // sides in metres; smallest side
    vec4 origin;       // corner of voxel 0, 0, 0; threshold
    ivec4 emitter_first; // voxels that overlap the emitter, first and last along each axis; w: 1 if there is one
    ivec4 emitter_last;
    vec4 emitter_low;  // the emitter in metres
    vec4 emitter_high;
    vec4 light;        // unit vector towards the light, w = 0; or its position, w = 1
    vec4 light_right;  // axes across a directional light
    vec4 light_up;
    vec4 light_frame;  // light-space tiles: low x, low y, 1 / side; largest distance of a penumbra's caster
    vec4 light_range;  // distances from the light: nearest, 1 / span
    vec4 shade;        // ambient, softness, scale of the radius, seconds between frames
    vec4 motion;       // metres a second at and below which a particle dies; share of the old depth range kept; hysteresis; group depth or 0
    uvec4 counts;      // particles, fade, sphere slots, seed
    uvec4 frame;       // frames since the restart; 1 if there is velocity; lifetime or 0; groups
    uvec4 shadow;      // levels of light-space tiles, cells of a face, faces, taps of the shadow map's filter
    uvec4 filtering;   // window, window in blocks, tones, row of the ring of dying spheres
    vec4 ink;          // outline: strength, width, smallest depth unit, pixel footprint at depth 1
    vec4 ink_colour;   // linear RGB; softness of tones
    uvec4 blocks;      // blocks of the occlusion test: side in pixels, across, down
    uvec4 levels[12];  // occupancy pyramid: first word, rows along y, rows along z
} params;

// What the device decides during a frame; the host resets it at the frame's start.
struct Control {
    uint live;          // spheres with a radius
    uint visible;       // those that can touch the screen
    uint unused_a;
    uint unused_b;
    uvec4 live_groups;  // dispatch over live spheres, 64 a group
    uvec4 draw;         // draw of visible spheres
    uvec4 light_draw;   // draw of live spheres
    uvec4 tile_groups;  // dispatch over occupied tiles
    uvec4 tile_draw;    // draw of occupied tiles
    uint depth_low;     // depth range of live spheres ahead of the near plane, ordered bits
    uint depth_high;
    uint light_low_x;   // bounds of live spheres in light space, ordered bits
    uint light_low_y;
    uint light_low_z;
    uint light_high_x;
    uint light_high_y;
    uint light_high_z;
};

// Survives from frame to frame.
struct History {
    float range_low;   // smoothed depth range
    float range_high;
    uint started;      // 0 until there is a range
    uint births;       // occupied voxels that a birth may choose
    uint longest;      // longest list of light-space tiles that one ray can meet
    uint unused_a;
    uint unused_b;
    uint unused_c;
};

#endif
