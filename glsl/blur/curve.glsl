// Points of the refined mesh: their splines, and what follows from them. A point is given by two vertices and where it is
// between them, as halving edges gets there: 0 the first, 1 a quarter of the way, 2 half of it, 3 three quarters. Nothing
// depends on which of the two comes first, so that both triangles of an edge agree to the bit.

layout(constant_id = 0) const uint SCREEN = 0;  // 1: splines are of pixels and not of clip coordinates

vec3 between(vec3 a, vec3 b, uint where) {
    precise vec3 middle = (a + b) * 0.5;
    precise vec3 quarter = ((where == 1u ? a : b) + middle) * 0.5;
    return where == 0u ? a : where == 2u ? middle : quarter;
}

float between(float a, float b, uint where) {
    precise float middle = (a + b) * 0.5;
    precise float quarter = ((where == 1u ? a : b) + middle) * 0.5;
    return where == 0u ? a : where == 2u ? middle : quarter;
}

// The piece of segment s.
Piece piece_of(uint a, uint b, uint where, uint s) {
    Piece from = splines[s * params.pieces.z + a];
    Piece to = splines[s * params.pieces.z + b];
    return Piece(vec4(between(from.origin.xyz, to.origin.xyz, where), 0.0),
                 vec4(between(from.step.xyz, to.step.xyz, where), 0.0),
                 vec4(between(from.bend_begin.xyz, to.bend_begin.xyz, where), 0.0),
                 vec4(between(from.bend_end.xyz, to.bend_end.xyz, where), 0.0));
}

// Where the point is in frame i.
vec3 start_of(uint a, uint b, uint where) {
    return between(splines[a].origin.xyz, splines[b].origin.xyz, where);
}

uint segment_at(float time) {
    uint s;
    if (time >= 0.0) {
        for (s = 0u; s + 1u < params.pieces.y && time > params.segments[s].y; ++s) {
        }
    } else {
        for (s = params.pieces.y; s < params.pieces.x && time < params.segments[s].x; ++s) {
        }
        // Before the earliest it goes on straight.
        s = s < params.pieces.x ? s : params.pieces.x > params.pieces.y ? params.pieces.x - 1u : 0u;
    }
    return s;
}

// How far the point is from where it is in frame i, so many frames after it.
vec3 offset_at(uint a, uint b, uint where, float time) {
    uint s = segment_at(time);
    Piece piece = piece_of(a, b, where, s);
    vec3 origin = s == 0u ? vec3(0.0) : piece.origin.xyz;
    vec3 way = piece.step.xyz;
    vec3 from = piece.bend_begin.xyz;
    vec3 to = piece.bend_end.xyz;
    precise float u = (time - params.segments[s].x) * params.segments[s].z;
    precise float left = 1.0 - u;
    precise float from_share = (left * left * left - left) / 6.0;
    precise float to_share = (u * u * u - u) / 6.0;
    precise vec3 curve = origin + u * way + from_share * from + to_share * to;
    precise vec3 line = origin + u * (way - from / 3.0 - to / 6.0);
    return u < 0.0 ? line : curve;
}

// Clip coordinates at a time.
vec3 clip_at(uint a, uint b, uint where, float time) {
    precise vec3 clip = start_of(a, b, where) + offset_at(a, b, where, time);
    if (SCREEN == 1u) {
        clip.xy = clip.xy * clip.z;
    }
    return clip;
}

// Position in pixels and velocity in pixels a frame, at the reference time.
vec4 motion_at(uint a, uint b, uint where) {
    float time = params.model.y;
    uint s = segment_at(time);
    Piece piece = piece_of(a, b, where, s);
    precise float u = (time - params.segments[s].x) * params.segments[s].z;
    precise float left = 1.0 - u;
    precise float from_share = (1.0 - 3.0 * left * left) / 6.0;
    precise float to_share = (3.0 * u * u - 1.0) / 6.0;
    precise vec3 speed = (piece.step.xyz + from_share * piece.bend_begin.xyz + to_share * piece.bend_end.xyz)
        * params.segments[s].z;
    vec3 start = start_of(a, b, where);
    vec3 off = offset_at(a, b, where, time);
    if (SCREEN == 1u) {
        precise vec2 at = start.xy + off.xy;
        return vec4(at, speed.xy);
    }
    // What is off from where the point is at frame i: nothing large cancels.
    vec2 pixel = start.xy / start.z;
    precise float depth = start.z + off.z;
    precise vec2 off_pixels = (off.xy - pixel * off.z) / depth;
    precise vec2 velocity = ((speed.xy - pixel * speed.z) - off_pixels * speed.z) / depth;
    precise vec2 at = pixel + off_pixels;
    return vec4(at, velocity);
}
