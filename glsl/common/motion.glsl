// How far what a pixel shows has moved in the picture since the frame before, with what `params` says of the view.
#include "common/half.glsl"
#include "common/widening.glsl"

// What the view of the frame before has, and this one has not. View space of this frame becomes that of the frame before by a rotation
// and a shift; of the rotation stands here what it has more than none: then nothing large cancels, and what has not moved has exactly 0.
layout(push_constant) uniform MotionConstants {
    vec4 right;          // rows of the rotation less 1; w: shift in metres
    vec4 up;
    vec4 forward;
    vec2 focal;          // of the frame before: pixels of a slope of 1; orthographic: of a metre
    vec2 focal_change;   // of the frame before less this one's
    vec2 centre_change;  // pixels: where a slope of 0 was seen in the frame before less where it is, without jitter
    float near;          // nearest depth that was seen in the frame before, metres: what was nearer counts as there
    uint moves;          // 0: nothing but the view has moved
    uint has_edges;      // 0: nothing covers pixels in part
} constants;

// Pixels to the right and down, from here to the frame before. The place in view space is seen at this slope, and has been moved by so many
// metres, along the axes of this frame's view, since the frame before.
vec2 motion_of(vec2 slope, vec3 place, vec3 moved) {
    vec4 before = vec4(place - moved, 1.0);
    vec3 change = vec3(dot(constants.right, before), dot(constants.up, before), dot(constants.forward, before)) - moved;
    bool is_parallel = params.is_orthographic != 0u;
    float depth = max(place.z + change.z, constants.near);
    vec2 slope_change = is_parallel ? change.xy : (change.xy - slope * change.z) / depth;
    vec2 pixels = constants.focal * slope_change + constants.focal_change * slope;
    return clamp(vec2(pixels.x, -pixels.y) + constants.centre_change, -MOST_HALF, MOST_HALF);
}
