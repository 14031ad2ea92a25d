// From world to view space (x right, y up, z = view depth, in metres), with what `params` says of the camera: rotation and eye, each
// as a sum of two floats.
#include "along.glsl"

// World to view space, rounded once: what a small sphere far away looks like depends on the last bits. w: what z lost.
vec4 to_view_and_rest(vec3 p) {
    vec2 x = two_sum(p.x, -params.camera.eye.x);
    vec2 y = two_sum(p.y, -params.camera.eye.y);
    vec2 z = two_sum(p.z, -params.camera.eye.z);
    vec3 q = vec3(x.x, y.x, z.x);
    vec3 q_low = vec3(x.y, y.y, z.y) - params.camera.eye_low.xyz;
    vec2 depth = along_parts(params.camera.forward.xyz, params.camera.forward_low.xyz, q, q_low);
    vec2 z_parts = two_sum(depth.x, depth.y);
    return vec4(along_row(params.camera.right.xyz, params.camera.right_low.xyz, q, q_low),
                along_row(params.camera.up.xyz, params.camera.up_low.xyz, q, q_low), z_parts);
}

vec3 to_view(vec3 p) {
    return to_view_and_rest(p).xyz;
}
