// The depths that buckets divide: low end, and buckets a metre.
vec2 bucket_scale() {
    float low = from_ordered(control.range_low);
    float high = from_ordered(control.range_high);
    return vec2(low, float(params.counts.y) / max(high - low, 1e-30));
}
