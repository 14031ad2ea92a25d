// Speed lines: ribbons along the ways that trailing points have come, which taper to nothing.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
layout(std430, binding = 6) readonly buffer Splines { Piece splines[]; };
layout(std430, binding = 4) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 7) readonly buffer Trailing { Trail trailing[]; };
#include "common/random.glsl"
#include "lines.glsl"
layout(location = 0) out float aside;                // pixels from the middle
layout(location = 1) out float share;  // of the way from its beginning
layout(location = 2) out float broad;  // pixels at its beginning
#include "curve.glsl"
#include "position.glsl"

const uvec2 CORNERS[6] = uvec2[](uvec2(0u, 0u), uvec2(1u, 0u), uvec2(0u, 1u), uvec2(0u, 1u), uvec2(1u, 0u), uvec2(1u, 1u));

void main() {
    uint index = uint(gl_VertexIndex);
    uint point = trailing[index / (LINE_VERTICES)].point;
    uvec2 corner = CORNERS[index % 6u];
    // What is nowhere is behind the near plane.
    gl_Position = vec4(0.0, 0.0, 1.0, -1.0);
    aside = 0.0;
    share = 0.0;
    broad = 0.0;
    if (point == NONE) {
        return;
    }
    float moved = vertices[point].time;
    vec2 shape = shape_of(point);
    float length_of = constants.length_of * shape.x;
    broad = constants.width * shape.y;
    // A line with any part behind the near plane is not drawn, so that no triangle has corners on both sides of it.
    for (uint part = 0u; part <= LINE_PARTS; ++part) {
        float back = float(part) / float(LINE_PARTS) * length_of;
        if (!(state_at(point, point, 0u, moved - back).depth > params.near)) {
            return;
        }
    }
    share = float(index / 6u % LINE_PARTS + corner.x) / float(LINE_PARTS);
    State state = state_at(point, point, 0u, moved - share * length_of);
    float speed = length(state.velocity);
    // A pixel wider than it is on both sides, for its soft edge.
    float reach = 0.5 * broad * (1.0 - share) + 1.0;
    aside = corner.y == 0u ? -reach : reach;
    vec2 across = speed > 1e-3 ? vec2(-state.velocity.y, state.velocity.x) / speed : vec2(0.0);
    vec2 at = state.position + aside * across;
    gl_Position = position_at(at, state.depth);
    // Nothing of a line is seen in perspective but its depth.
    gl_Position /= gl_Position.w;
}
