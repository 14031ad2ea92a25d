// Bounds of x / z over a circle with centre (x, z) and radius r, z > r: the slopes of the tangents from the origin.
vec2 tangent_range(float x, float z, float r) {
    float t = sqrt(max((z - r) * (z + r) + x * x, 0.0));
    return vec2((x * t - z * r) / (z * t + x * r), (x * t + z * r) / (z * t - x * r));
}
