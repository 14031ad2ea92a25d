// The depth that others are counted from; 0 unless the fire is far away.
float depth_base() {
    return uintBitsToFloat(control.base);
}

// A depth of the scene from there; what is before it is nearer than all of the fire.
float from_base(float depth) {
    float base = depth_base();
    return base > 0.0 && depth < base ? 0.0 : depth - base;
}

// A particle's centre from the eye.
vec3 from_eye(vec3 view) {
    return vec3(view.xy, view.z + depth_base());
}

// Ends of the range that buckets divide.
vec2 depth_range() {
    bool is_far = depth_base() > 0.0;
    return vec2(from_ordered(is_far ? control.depth_low : control.range_low), from_ordered(is_far ? control.depth_high : control.range_high));
}

// The depths that buckets divide: low end, and buckets a metre.
vec2 bucket_scale() {
    vec2 ends = depth_range();
    return vec2(ends.x, float(params.bucket_count) / max(ends.y - ends.x, 1e-30));
}
