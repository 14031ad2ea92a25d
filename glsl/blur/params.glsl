// What the host tells every blur kernel, and what kernels tell each other.
//
// Clip coordinates are (X, Y, W): X / W and Y / W are pixels of the picture, y down; W is the view depth in metres.
#ifndef BLUR_PARAMS
#define BLUR_PARAMS

#extension GL_GOOGLE_include_directive : require

const uint NONE = 0xffffffffu;     // no index, no bin, no colour: there is none
const uint TILE = 8u;              // pixels along each side of a tile, and of workgroups over pixels
const uint BLOCK = 256u;           // triangles of a workgroup of the refinement
const uint ROUNDS = 16u;           // rounds of it, at most
const uint USUAL_ROUNDS = 11u;     // after these, each round's tolerance is twice the one's before
const float UNIT = 262144.0;       // 1 - k' is a multiple of 2^-18 while it is smoothed
const uint BASE_MASK = 0x3ffffffu; // a triangle's last word: base triangle,
const uint SPLIT_SHIFT = 26u;      // which of its edges are split in this round,
const uint OPEN_SHIFT = 29u;       // which may be split in this round or later; where none may:
const uint CLOSED = 1u;            // of a triangle's last word: only its outside can be seen
const uint TURNED = 2u;            // its outside is where its corners follow each other clockwise, in frame i; next: i + 1
const uint FRONT_MASK = 7u;        // all of these
const uint SURFACE_SHIFT = 3u;     // its surface is above them, a number up to
const uint MOST_SURFACE = 0x7fffu;
const uint OBJECT_SHIFT = 18u;     // and above that its object
const uint MOST_OBJECT = 0x3fffu;
const uint CULLED = 1u << 26u;     // never seen, because the object is closed
// The cluster of a vertex between two clusters, or between such and others: k, l and k' are the mean of its parents', so
// that k' is continuous. (If it belonged to one of the two, k' would jump beside the other's vertices, and what crosses the
// jump would be split to the last round: hundreds of triangles for each one at a seam.)
const uint BETWEEN = 0xffffffffu;
const uint ENDED_BY_BUDGET = 1u;   // why the refinement ended with triangles that would have gone on
const uint ENDED_BY_ROUNDS = 2u;
const float STATIC = 0.5;          // pixels: what moves less from frame i to frame i + 1 stays where it is
const float NO_MEAN = 1e-6;        // a mean velocity below this share of the mean speed has no direction
const float COMMON = 0.5;          // the share of their speed that goes one way, for points to have a common direction
const float LEAST_EXTENT = 1e-3;   // pixels: a cluster or a row that is shorter has no front and rear
const uint SMOOTHED = 2u;           // rows to both sides that front and rear of a cluster are a mean over: half a tooth
const float LEAST_EDGE = 0.25;     // length in pixels below which an edge is not divided
const float LEAST_SURFACE = 1.0 / 64.0; // length in pixels at the reference time: less of the surface is not divided
const uint FRONT_BITS = 4u;        // of a triangle: FRONT_MASK, and one that is unused
const uint FRONTS_A_WORD = 32u / FRONT_BITS;
const uint MOST_SEGMENTS = 32u;    // of a trajectory
const uint CURVE_KEYS = 8u;        // of strength over speed
const uint CURVE_ROWS = CURVE_KEYS / 2u;
const uint PIECE_SEGMENTS = 12u;   // of one that is made of poses
const uint LINE_PARTS = 16u;       // of a speed line
const uint LINE_VERTICES = 6u * LINE_PARTS; // two triangles a part

// What a frame is seen through: rows that make X, Y and the view depth Z of a point less the eye, and the eye, each as a sum of two
// floats. X / Z and Y / Z are pixels; orthographic: X and Y.
struct View {
    vec4 across;      // row of X; w: what is added, if it is orthographic
    vec4 down;        // row of Y; w: as well
    vec4 along;       // row of Z; w: unused
    vec4 across_low;
    vec4 down_low;
    vec4 along_low;
    vec4 eye;         // metres; w: pixels of a slope of 1, seen from a `depth_unit` if it is orthographic
    vec4 eye_low;
};

// When a segment of the trajectories begins and ends, in frames after frame i.
struct SegmentTimes {
    float begin;
    float end;
    uvec2 unused;  // elements of arrays in uniform blocks are 16 bytes apart
};

layout(binding = 0) uniform BlurParams {
    View views[4];             // frames i - 1, i, i + 1, i + 2
    uvec4 pose_places;         // where their poses are among those on the device
    vec4 background;           // colour where no frame shows anything but the mesh, if there is no image of it
    SegmentTimes segments[MOST_SEGMENTS];
    uvec2 size;                // of the picture, in pixels
    uvec2 corner;              // of the picture, in the target
    uvec2 tiles;               // of the picture, across and down
    uint seed;
    uint generation;           // of the teeth
    uint points;               // of the mesh
    uint triangles;            // of the mesh
    uint knots;                // frames that trajectories go through
    uint seam_points;          // points whose k' is smoothed
    uint segment_count;
    uint segments_ahead;       // segments that begin at 0 or later: they come first
    uint vertex_room;          // vertices that there is room for, in each segment of the splines
    uint triangle_budget;      // triangles that refinement may make
    uint list_room;            // samples that there is room for in each list of completion
    uint tables;               // surfaces that there are tables of colours for
    vec4 curve[CURVE_ROWS];    // keys of the share of strength, two a row: speed in pixels a frame, and share
    uint curve_keys;           // how many there are
    float strength;            // how far the smear reaches back, in frames
    float lead;                // how far it reaches ahead, in frames
    float dry_back;            // pixels that what ends in all of its bristles is drawn back
    float reach;               // frames before frame i that trajectories are looked at
    float reference_time;      // frames after frame i
    float tolerance;           // pixels
    float edge;                // the longest one with `refine = "length"`, in pixels
    float near;                // near plane in metres
    float far;                 // far plane; only what is orthographic ends there
    float depth_unit;          // what shares of a depth are shares of in orthographic views, metres
    float winding;             // -1 if views mirror: what runs counter-clockwise is seen clockwise; else 1
    vec2 jitter_change;        // how much farther frame i + 1 is moved than frame i, in pixels
    vec2 depth_terms;          // of the host's depth images
    uint is_orthographic;
    float skirt;               // pixels
    float hull_margin;         // how far apart products on a hull may be that rounding could have swapped
    uint outer_images;         // bits: 1: there is an image of frame i - 1, 2: of frame i + 2
    uint has_background_image; // what is behind everything is an image
    uint is_drawn;             // frames are drawn by this effect
    uint is_over_background;   // frames lie over the background
    uint is_clipped;           // what is outside of the picture is not refined
    uint is_whole;             // all tiles are worked on
    uint has_directions;       // hulls are the farthest points in DIRECTIONS directions
} params;

// A knot of the trajectories: a frame of the window.
struct Knot {
    vec4 across;           // row of X; w: what the eye's way from frame i's adds to it
    vec4 down;
    vec4 along;
    vec4 across_low;       // what these lost in rounding
    vec4 down_low;
    vec4 along_low;
    vec4 across_turn;      // the row less frame i's; w: unused
    vec4 down_turn;
    vec4 along_turn;
    vec4 across_turn_low;
    vec4 down_turn_low;
    vec4 along_turn_low;
    vec4 weights[PIECE_SEGMENTS]; // share of its offset in each row of the pieces, four a segment
    uint pose_place;       // where its pose is among those on the device
    uint has_other_view;   // it is seen through another view than frame i
    uvec2 unused;
};

// Points that are smeared as one.
struct Cluster {
    uint object;      // of all its points
    uint bounds_begin;  // of its rows; without these its hull: what is on the convex outline, in its order, and what is so near that
                        // rounding can make it extreme
    uint bounds_end;    // the one after the last
    uint teeth;       // random numbers N across it, 1 to 4096
    uint points;      // number of its points
    float aside;      // where its rows begin, along its direction turned by a quarter, in pixels
    vec2 ahead;       // its direction, of length 1; 0 where it has no rows
    float width;      // from the first row to the last, in pixels
    uint unused;
};

// Members of a part that a workgroup looks at.
struct Chunk {
    uint part;
    uint begin;  // first member
    uint end;    // the one after the last
    uint unused;
};

// A part of the mesh that the host has named.
struct PartRow {
    uint object;
    uint first_chunk;
    uint last_chunk;  // the one after the last
    uint unused;
};

// A piece of a point's trajectory: y(u) = y(0) + u D + ((1 - u)^3 - (1 - u)) / 6 M0 + (u^3 - u) / 6 M1, where u is 0 to 1
// from the segment's begin to its end. Components x, y, z; the fourth is 0. In homogeneous space these are pixel clip
// coordinates: x / z and y / z are pixels, y down, and z is the view depth in metres. In screen space, and where views are orthographic, x
// and y are pixels.
struct Piece {
    vec4 origin;      // y(0): of the segment from 0 as it is, of all others less what it is in frame i
    vec4 step;        // D
    vec4 bend_begin;  // M0
    vec4 bend_end;    // M1
};

// A point of the mesh at the reference time.
struct PointMotion {
    vec2 position;  // pixels
    vec2 velocity;  // pixels a frame
};

// Barycentrics of the mesh's own points, which are corners of many triangles.
const float OF_POINT = -1.0;

// A vertex of the refined mesh. The mesh's own points come first.
struct Vertex {
    vec2 position;     // pixels, at the reference time
    vec2 velocity;     // pixels a frame, there
    float k;           // how far front it is in its cluster, 0 (rear) to 1
    float l;           // how far across it is, 0 to 1
    float smoothing;   // what smoothing adds to k'
    float time;        // k': when it is drawn, in frames after frame i
    vec2 drawn;        // where it is drawn, in pixels
    float drawn_depth; // view depth there, in metres
    float drawn_time;  // `time`, beside what is read with it
    uint cluster;      // from 1; 0: it stays where it is; or BETWEEN
    float share;       // of strength: how much of it there is
    vec2 barycentrics; // in its base triangle, of the second and the third corner; OF_POINT: it is of the mesh
};

// A round of the refinement.
struct Round {
    uvec4 groups;          // dispatch over its triangles; w: unused
    uint triangles;
    uint finished_before;  // finished triangles before it
    uint vertices_before;  // vertices before it
    uint unused;
};

// What the device decides during a frame.
struct Control {
    uvec4 draw;      // draw of the finished triangles
    uint triangles;  // finished ones
    uint vertices;
    uint ended_by;   // 0: nothing was left to divide, ENDED_BY_BUDGET, ENDED_BY_ROUNDS
    uint undivided;  // triangles that would have gone on
};

// The rearmost point of a strip of a cluster, from which a speed line trails: all bits are set while there is none.
struct Trail {
    uint k;      // bits of its k,
    uint l;      // of its l,
    uint point;
    uint unused;
};

// What the mesh covers a pixel with, for those that draw something behind it. The host shares it between effects.
struct Covering {
    uvec2 colour;  // premultiplied by the share that is covered, and that share, as halves
    float depth;   // view depth of what of the mesh is nearest; another part of it may be behind that
    float behind;  // view depth behind which all of the pixel is covered; where it is not: depth of what was there
};

#endif
