// Distances are combined as they are measured: along each axis, then the largest, or the root of the sum of squares.
float combined(float a, float b, float c) {
    return is_ball() ? sqrt(a * a + b * b + c * c) : max(a, max(b, c));
}
