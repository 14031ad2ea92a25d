// Between positions and voxels.
#include "../common/exact.glsl"

float voxel_centre(int index, int axis) {
    precise float c = params.origin[axis] + (float(index) + 0.5) * params.voxel_size[axis];
    return c;
}

// Whether p < origin + index * side in exact arithmetic, so that a particle on a face is on the same side for everybody.
bool is_below_face(float p, int index, int axis) {
    vec2 product = two_product(float(index), params.voxel_size[axis]);
    vec2 offset = two_sum(p, -params.origin[axis]);
    precise float difference = offset.x - product.x;
    precise float rest = offset.y - product.y;
    return difference + rest < 0.0;
}

int voxel_along(float p, int axis) {
    float guess = floor((p - params.origin[axis]) / params.voxel_size[axis]);
    int index = int(clamp(guess, -2.0, float(params.dimensions[axis]) + 1.0));
    if (is_below_face(p, index, axis)) {
        return index - 1;
    }
    return is_below_face(p, index + 1, axis) ? index : index + 1;
}

ivec3 voxel_of(vec3 p) {
    return ivec3(voxel_along(p.x, 0), voxel_along(p.y, 1), voxel_along(p.z, 2));
}

bool is_inside(ivec3 v) {
    return all(greaterThanEqual(v, ivec3(0))) && all(lessThan(v, ivec3(params.dimensions.xyz)));
}
