// Between positions and voxels.
float voxel_centre(int index, int axis) {
    precise float c = params.origin[axis] + (float(index) + 0.5) * params.voxel[axis];
    return c;
}

// Whether p < origin + index * side in exact arithmetic: error-free product (Dekker) and sums (Knuth), so that a
// particle on a face is on the same side for everybody.
bool is_below_face(float p, int index, int axis) {
    precise float side = params.voxel[axis];
    precise float k = float(index);
    precise float product = k * side;
    precise float split_s = side * 4097.0;
    precise float high_s = split_s - (split_s - side);
    precise float low_s = side - high_s;
    precise float split_k = k * 4097.0;
    precise float high_k = split_k - (split_k - k);
    precise float low_k = k - high_k;
    precise float product_error = ((high_k * high_s - product) + high_k * low_s + low_k * high_s) + low_k * low_s;
    precise float origin = params.origin[axis];
    precise float offset = p - origin;
    precise float back = offset - p;
    precise float offset_error = (p - (offset - back)) - (origin + back);
    precise float difference = offset - product;
    precise float rest = offset_error - product_error;
    return difference + rest < 0.0;
}

int voxel_along(float p, int axis) {
    float guess = floor((p - params.origin[axis]) / params.voxel[axis]);
    int index = int(clamp(guess, -2.0, float(params.grid[axis]) + 1.0));
    if (is_below_face(p, index, axis)) {
        return index - 1;
    }
    return is_below_face(p, index + 1, axis) ? index : index + 1;
}

ivec3 voxel_of(vec3 p) {
    return ivec3(voxel_along(p.x, 0), voxel_along(p.y, 1), voxel_along(p.z, 2));
}

bool is_inside(ivec3 v) {
    return all(greaterThanEqual(v, ivec3(0))) && all(lessThan(v, ivec3(params.grid.xyz)));
}
