// Alpha of the mask where a sprite meets a pixel, `t` in texels of its level from its corner; 0 outside.
layout(constant_id = 3) const uint MAGNIFIED = 0;  // 1: level 0, look-ups are bilinear

float mask_value(vec2 t, uint texel, uint level) {
    int top = int(texel >> 16u) * int(MASK_SIDE);
    if (MAGNIFIED == 1u) {
        const int LAST = int(MASK_SIDE) - 1;
        vec2 at = t - 0.5;
        vec2 low = floor(at);
        vec2 f = at - low;
        ivec2 a = clamp(ivec2(low), ivec2(0), ivec2(LAST));
        ivec2 b = clamp(ivec2(low) + 1, ivec2(0), ivec2(LAST));
        float upper = mix(imageLoad(levels, ivec2(a.x, top + a.y)).r, imageLoad(levels, ivec2(b.x, top + a.y)).r, f.x);
        float lower = mix(imageLoad(levels, ivec2(a.x, top + b.y)).r, imageLoad(levels, ivec2(b.x, top + b.y)).r, f.x);
        vec2 u = t * (2.0 / float(MASK_SIDE)) - 1.0;
        return dot(u, u) < 1.0 ? mix(upper, lower, f.y) : 0.0;
    }
    uint place = texel & 0xffffu;
    int last = int(MASK_SIDE >> level) - 1;
    ivec2 whole = ivec2(floor(t));
    ivec2 at = clamp(whole, ivec2(0), ivec2(last));
    ivec2 inside = ivec2(place & ((1u << level) - 1u), place >> level);
    float alpha = imageLoad(levels, ivec2(int(level * MASK_SIDE), top) + (at << int(level)) + inside).r;
    return whole == at ? alpha : 0.0;
}
