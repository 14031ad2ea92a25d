// A shadow map's view of the scene. Directional light: parallel, square, bounding the live spheres. Point light: six faces
// of a cube. Depth is reversed: 1 nearest to the light, 0 nothing.
#include "../common/bits.glsl"
#include "map_near.glsl"

// Low corner x, y, lowest z; side: in light space, z towards the light.
vec4 map_frame() {
    vec3 low = vec3(from_ordered(control.light_low_x), from_ordered(control.light_low_y),
                    from_ordered(control.light_low_z));
    vec3 high = vec3(from_ordered(control.light_high_x), from_ordered(control.light_high_y),
                     from_ordered(control.light_high_z));
    float side = max(max(high.x - low.x, high.y - low.y), high.z - low.z);
    return vec4(low, max(side, 1e-30));
}
