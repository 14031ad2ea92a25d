// Colours as hue (0 to 1), saturation and value, and alpha.

const float GREY = 0.05;  // saturation below which a colour has no hue

vec4 hsva(vec4 colour) {
    vec3 c = colour.w > 0.0 ? colour.xyz / colour.w : vec3(0.0);
    float value = max(max(c.x, c.y), c.z);
    float range = value - min(min(c.x, c.y), c.z);
    if (!(value > 0.0 && range > 0.0)) {
        return vec4(0.0, 0.0, max(value, 0.0), colour.w);
    }
    float sixths = value == c.x ? (c.y - c.z) / range : value == c.y ? 2.0 + (c.z - c.x) / range : 4.0 + (c.x - c.y) / range;
    return vec4(fract(sixths / 6.0), range / value, value, colour.w);
}

// What changes from a premultiplied colour to another. The hue does not, where either has none.
vec4 change(vec4 to, vec4 from) {
    vec4 there = hsva(to);
    vec4 here = hsva(from);
    vec4 way = there - here;
    way.x = min(there.y, here.y) < GREY ? 0.0 : way.x - floor(way.x + 0.5);
    return way;
}

// A premultiplied colour, changed.
vec4 changed(vec4 colour, vec4 way, float brightest) {
    vec4 from = hsva(colour);
    vec4 to = vec4(from.x + way.x, clamp(from.y + way.y, 0.0, 1.0), clamp(from.z + way.z, 0.0, brightest), clamp(from.w + way.w, 0.0, 1.0));
    vec3 place = mod(vec3(5.0, 3.0, 1.0) + 6.0 * to.x, 6.0);
    vec3 rgb = to.z - to.z * to.y * clamp(min(place, 4.0 - place), 0.0, 1.0);
    return vec4(rgb * to.w, to.w);
}
