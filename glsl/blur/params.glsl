// What the host tells every blur kernel, and what kernels tell each other. `src/blur/params.rs` has the same structures;
// build.rs compares offsets and sizes.
//
// Clip coordinates are (X, Y, W): X / W and Y / W are pixels of the picture, y down; W is the view depth in metres.
#ifndef BLUR_PARAMS
#define BLUR_PARAMS

#extension GL_GOOGLE_include_directive : require

const uint BLOCK = 128u;           // triangles of a workgroup of the refinement
const uint ROUNDS = 16u;           // rounds of it
const float UNIT = 262144.0;        // 1 - k' is a multiple of 2^-18 while it is smoothed
const uint BASE_MASK = 0x3ffffffu; // a triangle's last word: base triangle,
const uint SPLIT_SHIFT = 26u;      // which of its edges are split in this round,
const uint OPEN_SHIFT = 29u;       // which may be split in this round or later; where none may:
const uint CLOSED = 1u;            // of a triangle's last word: only its outside can be seen
const uint TURNED = 2u;            // its outside is where its corners follow each other clockwise, in frame i; next: i + 1
const uint FRONT_MASK = 7u;        // all of these
const uint OBJECT_SHIFT = 3u;      // its object is above them
const uint CULLED = 1u << 26u;     // never seen, because the object is closed
const uint BETWEEN = 0xffffffffu;  // the cluster of what is between clusters

// A frame's camera: rows that make X, Y and W of a point, and the eye, each as a sum of two floats.
struct View {
    vec4 across;      // w: unused
    vec4 down;
    vec4 along;
    vec4 across_low;
    vec4 down_low;
    vec4 along_low;
    vec4 eye;
    vec4 eye_low;
    uvec4 slot;       // where the frame's pose is; the rest is unused
};

layout(binding = 0) uniform BlurParams {
    View views[4];      // frames i - 1, i, i + 1, i + 2
    uvec4 image;        // width, height, seed, generation of the teeth
    uvec4 counts;       // points, triangles, knots, points at seams
    uvec4 pieces;       // segments, those of them that begin at 0 or later, vertices that there is room for, triangles that there may be
    vec4 model;         // strength, reference time, tolerance and longest edge in pixels
    vec4 lens;          // near plane in metres, least length of an edge in pixels, how far apart products on a hull may be that rounding could have swapped; unused
    uvec4 modes;        // 1 if frames are drawn, and so lie over the background; 1 if what is outside the picture is not refined; 1 if all tiles are worked on; unused
    vec4 background;    // colour where no frame shows anything but the mesh, if there is no image of it
    vec4 segments[32];  // begin and end of each segment in frames after frame i; unused
    uvec4 completion;   // objects that there are tables for, whether there are images of frames i - 1 (1) and i + 2 (2), and of the background (4), bits of the skirt in pixels, room in each list of samples
} params;

// A knot of the trajectories: a frame of the window.
struct Knot {
    vec4 across;      // row of X; w: what the camera's way from frame i's adds to it
    vec4 down;
    vec4 along;
    vec4 across_low;  // what these lost in rounding
    vec4 down_low;
    vec4 along_low;
    vec4 across_turn; // the row less frame i's; w: unused
    vec4 down_turn;
    vec4 along_turn;
    vec4 across_turn_low;
    vec4 down_turn_low;
    vec4 along_turn_low;
    uvec4 slot;       // where its pose is; 1 if its camera is not frame i's; the rest is unused
    vec4 weights[12]; // share of its offset in each row of the pieces, four a segment
};

// Points that are smeared as one.
struct Cluster {
    uint object;      // of all its points
    uint hull_begin;  // in the order of the convex outline: what is on it, and what is so near that rounding can make it extreme
    uint hull_end;    // the one after the last
    uint teeth;       // random numbers N across it, 1 to 4096
    uint points;      // number of its points
};

// A piece of a point's trajectory: y(u) = y(0) + u D + ((1 - u)^3 - (1 - u)) / 6 M0 + (u^3 - u) / 6 M1, where u is 0 to 1
// from the segment's begin to its end. Components x, y, w; the fourth is 0. In homogeneous space these are pixel clip
// coordinates: x / w and y / w are pixels, y down, and w is the view depth in metres. In screen space x and y are pixels.
struct Piece {
    vec4 origin;      // y(0): of the segment from 0 as it is, of all others less what it is in frame i
    vec4 step;        // D
    vec4 bend_begin;  // M0
    vec4 bend_end;    // M1
};

// A vertex of the refined mesh. The mesh's own points come first.
struct Vertex {
    vec4 motion;      // x, y in pixels and velocity in pixels a frame, at the reference time
    vec4 extent;      // k, l, what smoothing adds to k', k'
    vec4 drawn;       // x and y in pixels and view depth where it is drawn, k'
    uvec4 place;      // cluster from 1, 0: unmoved, BETWEEN; 1 if it is of the mesh; barycentric coordinates in its base triangle, of the second and the third corner, as bits
};

// A round of the refinement.
struct Round {
    uvec4 groups;     // dispatch over its triangles; w: their number
    uvec4 scan;       // dispatch of the scan; w: 1 if it divides nothing
    uvec4 made;       // finished triangles before it, vertices before it, unused
};

// What the device decides during a frame.
struct Control {
    uvec4 draw;       // draw of the finished triangles
    uvec4 refined;    // triangles, vertices; 1 if the budget, 2 if the rounds ended the refinement; triangles that would have gone on
};

#endif
