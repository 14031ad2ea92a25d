// Points of the refined mesh: their splines, and what follows from them. A point is given by two vertices and where it is
// between them, as halving edges gets there: 0 the first, 1 a quarter of the way, 2 half of it, 3 three quarters. Nothing
// depends on which of the two comes first, so that both triangles of an edge agree to the bit.

layout(constant_id = 0) const uint SCREEN = 0;  // 1: splines are of pixels and not of clip coordinates

vec3 between(vec3 a, vec3 b, uint where) {
    precise vec3 middle = (a + b) * 0.5;
    precise vec3 quarter = ((where == 1u ? a : b) + middle) * 0.5;
    vec3 inner = where == 2u ? middle : quarter;
    return where == 0u ? a : inner;
}

float between(float a, float b, uint where) {
    precise float middle = (a + b) * 0.5;
    precise float quarter = ((where == 1u ? a : b) + middle) * 0.5;
    float inner = where == 2u ? middle : quarter;
    return where == 0u ? a : inner;
}

// The piece of segment s.
Piece piece_of(uint a, uint b, uint where, uint s) {
    Piece from = splines[s * params.vertex_room + a];
    Piece to = splines[s * params.vertex_room + b];
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
        for (s = 0u; s + 1u < params.segments_ahead && time > params.segments[s].end; ++s) {
        }
    } else {
        for (s = params.segments_ahead; s < params.segment_count && time < params.segments[s].begin; ++s) {
        }
        // Before the earliest it goes on straight.
        s = s < params.segment_count ? s : params.segment_count > params.segments_ahead ? params.segment_count - 1u : 0u;
    }
    return s;
}

// How far the point is from where it is in frame i, so many frames after it, and the derivative by time.
struct Offset {
    vec3 off;
    vec3 slope;
};

Offset offset_at(uint a, uint b, uint where, float time) {
    uint s = segment_at(time);
    Piece piece = piece_of(a, b, where, s);
    float begin = params.segments[s].begin;
    precise float length_of = params.segments[s].end - begin;
    precise float past = time - begin;
    precise float late = time - params.segments[s].end;
    float beyond = time < begin ? past : max(late, 0.0);
    precise float u = (time - beyond - begin) / length_of;
    precise float c = 1.0 - u;
    precise float from = (c * c * c - c) * (1.0 / 6.0);
    precise float to = (u * u * u - u) * (1.0 / 6.0);
    precise float from_slope = (1.0 - 3.0 * (c * c)) * (1.0 / 6.0);
    precise float to_slope = (3.0 * (u * u) - 1.0) * (1.0 / 6.0);
    vec3 own = piece.origin.xyz;
    vec3 origin = s == 0u ? vec3(0.0) : own;
    precise vec3 slope = (piece.step.xyz + from_slope * piece.bend_begin.xyz + to_slope * piece.bend_end.xyz) / length_of;
    precise vec3 value = origin + (u * piece.step.xyz + from * piece.bend_begin.xyz + to * piece.bend_end.xyz);
    // Straight before the earliest segment and after the latest.
    precise vec3 line = value + beyond * slope;
    return Offset(beyond == 0.0 ? value : line, slope);
}

// Where the point is in pixels, as what it is off from frame i, so that it is exact for what hardly moves; and its depth.
struct State {
    vec2 position;
    vec2 velocity;  // pixels a frame
    float depth;
};

State state_at(uint a, uint b, uint where, float time) {
    vec3 start = start_of(a, b, where);
    Offset at = offset_at(a, b, where, time);
    precise float depth = start.z + at.off.z;
    if (SCREEN == 1u || params.is_orthographic != 0u) {
        precise vec2 position = start.xy + at.off.xy;
        return State(position, at.slope.xy, depth);
    }
    precise vec2 from = start.xy / start.z;
    precise vec2 moved = (at.off.xy - from * at.off.z) / depth;
    precise vec2 position = from + moved;
    precise vec2 velocity = (at.slope.xy - position * at.slope.z) / depth;
    return State(position, velocity, depth);
}
