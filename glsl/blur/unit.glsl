// A direction.
#include "common/bits.glsl"

// Of length 1; 0 of what has no direction.
vec3 unit(vec3 normal) {
    float most = max(max(abs(normal.x), abs(normal.y)), abs(normal.z));
    bool has_direction = most > 0.0 && most < INFINITY;
    return has_direction ? normalize(normal / most) : vec3(0.0);
}
