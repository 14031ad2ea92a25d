// What the host tells every smoke kernel, and what kernels tell each other.
#ifndef SMOKE_PARAMS
#define SMOKE_PARAMS

#extension GL_GOOGLE_include_directive : require

#include "common/bits.glsl"
#include "common/camera.glsl"

const uint TILE = 32u;                 // side of a screen tile in pixels
const uint BLOCK = 8u;                 // side of a block in pixels
const uint TILE_BLOCKS = TILE / BLOCK; // blocks of a tile across and down
const uint SLOT_PIXELS = TILE * TILE;  // pixels of a tile
const uint MAX_LIGHT_LEVELS = 16u;  // levels of light-space tiles: more than there are
const uint LIST_RUN = 16u;             // sphere slots that one invocation counts and lists
const uint LIVE_LANES = 64u;           // invocations of a workgroup of kernels over live spheres
const uint QUAD_VERTICES = 4u;         // what a draw of a sphere or tile has
const float HELD_RANGE = -1.0;         // instead of a share
const uint MOST_DETAIL_WINDOW = 24u;   // voxels to each side that the Gaussian of the density can have
const uint MAX_LEVELS = 12u;           // levels that a pyramid can have

// A level of the pyramid that radii are searched in: of occupancy, or of the cells that the threshold crosses.
struct PyramidLevel {
    uint first_word;
    uint rows_y;  // rows along y
    uint rows_z;  // rows along z
    uint unused;
};

layout(binding = 0) uniform SmokeParams {
    CameraRows camera;
    vec2 half_extent;  // of the picture at depth 1, along x and y; orthographic: at any depth
    vec2 off_axis;     // slope of what is seen in the middle, to the right and up; orthographic: metres
    vec2 depth_terms;  // of the host's depth images
    float near;        // nearest depth that is seen, metres
    float far;         // farthest
    uvec2 size;        // of the picture in pixels
    uvec2 tiles;       // across and down
    uvec2 corner;      // of the picture, in the target
    uint row_groups;  // groups or planes whose row sums are in memory
    float smallest;    // sphere that is drawn at its size, diameter in pixels
    uvec2 occlusion_blocks;  // of the occlusion test, across and down
    uint is_orthographic;
    uint range_before;       // where the depth range of the frame before stands

    vec4 voxel_size;      // sides in metres; w: unused
    vec4 origin;          // corner of voxel (0, 0, 0) in metres; w: unused
    uvec4 dimensions;     // voxels along x, y, z; w: unused
    uint row_words;       // words of a row of occupancy bits
    float smallest_side;  // of a voxel, metres
    float threshold;      // a voxel is occupied where density is above
    uint has_emitter;
    ivec4 emitter_first;  // first voxel along each axis that overlaps the emitter; w: unused
    ivec4 emitter_last;   // last
    vec4 emitter_min;     // lower corner of the emitter in metres; w: unused
    vec4 emitter_max;     // upper corner

    vec4 light;                // unit vector towards a directional light, position of a point light; w: unused
    vec4 fill;                 // unit axis of the hemisphere that fills; w: its share of the light
    vec4 light_right;          // axes across a directional light; w: unused
    vec4 light_up;
    vec4 second_light;         // homogeneous: unit vector to it (w = 0), or where it is (w = 1)
    vec4 fire;                 // where the fire is; w: 1 / squared distance at which half of its light arrives
    vec4 fire_colour;          // linear RGB; w: unused
    vec4 height;               // of a place in view space over where the colours of tones begin to change; w: of the eye
    float second_strength;     // of the second light
    float rim;                 // brightness of edges that turn away
    float gradient_height;     // over which the colours of tones change, metres
    uint tones_above;          // how many there are higher up
    vec2 light_low;            // low corner of the light-space tiles
    float light_inverse_side;  // 1 / side of what they cover
    float caster_distance;     // largest distance of what casts a penumbra, metres
    uint is_point_light;
    float light_nearest;       // least distance from the light, metres
    float light_inverse_span;  // 1 / (largest - least distance from the light)
    float ambient;
    uint light_levels;         // levels of light-space tiles
    uint light_cells;          // light-space tiles of a face
    uint light_faces;          // 1, or 6 for a point light
    uint shadow_filter;        // taps of the shadow map's filter along an axis

    uint particles;
    uint fade;          // frames over which spheres grow and shrink
    uint spheres;       // particles and the ring of dying ones
    uint seed;
    uint frames;        // since the restart
    uint has_velocity;
    uint lifetime;      // frames; 0: none
    uint ring_row;      // of the dying spheres' ring, for this frame's deaths
    float dt;           // seconds between frames
    float still_speed;  // a particle this slow dies, metres per second
    float scale;        // of the radius
    float softness;     // tangent of the light's half angle

    uint group_count;
    float group_depth;      // metres; 0: equal ranges of the smoke's own depth
    float range_smoothing;  // share of the old depth range that is kept; HELD_RANGE: it moves as the depths do
    float hysteresis;       // share of a group's range
    uint window;            // of the Gaussian to each side, in pixels
    uint window_blocks;     // the same in blocks
    uint tone_count;
    float tone_softness;    // width of the border between tones, pixels
    vec4 silhouette_colour;  // linear RGB; w: opacity
    vec4 inner_colour;       // of other lines; w: unused
    float silhouette_width;  // pixels
    float inner_width;
    float inner_strength;
    float outline_taper;     // share of the width that the lowest steps have not
    float shortest_line;     // pixels
    uint trace_reach;        // pixels that a line goes on along low steps
    uint piece_reach;        // pixels along a line that are looked at
    float pixel_footprint;  // metres at depth 1; orthographic: at any depth
    uint occlusion_side;    // of a block of the occlusion test, pixels
    vec4 detail_weights[MOST_DETAIL_WINDOW + 1u];  // of the Gaussian of the density, by distance in voxels; w: unused
    uvec4 detail_window;    // where it ends, voxels to each side; w: unused
    uint crossing_row_words;  // words of a row of the cells that the threshold crosses
    float radius_smoothing;   // share of the last frame's radius that is kept
    float boil;               // how much a radius differs from drawing to drawing, as a share of BOIL_SIZE
    uint unused_levels;
    PyramidLevel levels[MAX_LEVELS];
} params;

// What the device decides during a frame; the host resets it at the frame's start.
struct Control {
    uint live;          // spheres with a radius
    uint visible;       // those that can touch the screen
    uint depth_low;     // depth range of live spheres ahead of the near plane, ordered bits
    uint depth_high;
    uvec4 live_groups;  // dispatch over live spheres
    uvec4 draw;         // draw of visible spheres
    uvec4 light_draw;   // draw of live spheres
    uvec4 tile_groups;  // dispatch over occupied tiles
    uvec4 tile_draw;    // draw of occupied tiles
    uint light_low_x;   // bounds of live spheres in light space, ordered bits
    uint light_low_y;
    uint light_low_z;
    uint light_high_x;
    uint light_high_y;
    uint light_high_z;
    float group_start;       // of the first range of depth, metres
    float groups_per_metre;  // 0: ranges have no width
    uint unused_low;
    uint unused_high;
    uint longest[MAX_LIGHT_LEVELS];  // longest list of light-space tiles of each level
};

// A smoothed depth range, if there is one, and the range of depths itself.
struct Range {
    float low;
    float high;
    uint exists;
    float lowest;
    float highest;
};

// Survives from frame to frame.
struct History {
    Range ranges[2];  // of this frame and of the one before
};

#endif
