// Strength of the ink line at a place, before its width: 1 - l with l = max(0, 1 - w l') (smoke's paper, section 3.5).

layout(constant_id = 0) const uint SECOND = 0u;  // 1: second differences

// `beside`: depths of the neighbours along one diagonal, then along the other; `per_unit`: by what differences count.
float ink_at(float centre, vec4 beside, float per_unit, float strength) {
    float first = SECOND != 0u ? (beside.x - centre) + (beside.y - centre) : beside.x - beside.y;
    float second = SECOND != 0u ? (beside.z - centre) + (beside.w - centre) : beside.z - beside.w;
    first *= per_unit;
    second *= per_unit;
    return 1.0 - max(0.0, 1.0 - strength * (first * first + second * second));
}
