// View depth as lines are found in it: in units of max(smallest voxel side, eight pixel footprints), so that what is a line
// depends neither on distance nor on resolution, and slopes stay clean. Beyond the picture is its border.
#include "common/widening.glsl"
layout(std430, binding = 2) readonly buffer Depth { float depth[]; };

float depth_at(ivec2 at) {
    return depth[pixel_index(uvec2(clamp(at, ivec2(0), ivec2(params.size) - 1)))];
}

// Metres to units, at a depth.
float per_unit_at(float centre) {
    return 1.0 / max(params.smallest_side, 8.0 * params.pixel_footprint * widening(centre));
}
