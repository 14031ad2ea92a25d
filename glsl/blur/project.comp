// Clip coordinates of every point at frames i - 1, i, i + 1 and i + 2.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "../common/along.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Poses { float poses[]; };
layout(std430, binding = 2) writeonly buffer Clip { vec4 clip[]; };
#include "poses.glsl"

void main() {
    uint point = gl_GlobalInvocationID.x;
    uint index = gl_GlobalInvocationID.y;
    if (point >= params.points) {
        return;
    }
    View view = params.views[index];
    vec3 at = pose(params.pose_places[index], point);
    vec2 x = two_sum(at.x, -view.eye.x);
    vec2 y = two_sum(at.y, -view.eye.y);
    vec2 z = two_sum(at.z, -view.eye.z);
    vec3 q = vec3(x.x, y.x, z.x);
    vec3 q_low = vec3(x.y, y.y, z.y) - view.eye_low.xyz;
    clip[index * params.points + point] = vec4(along_row(view.across.xyz, view.across_low.xyz, q, q_low) + view.across.w,
                                                 along_row(view.down.xyz, view.down_low.xyz, q, q_low) + view.down.w,
                                                 along_row(view.along.xyz, view.along_low.xyz, q, q_low), 0.0);
}
