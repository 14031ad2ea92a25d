// Depth bins, front to back. Along the optical depth x of a bin colours are taken to be linear, c + b (x - h / 2), with a slope from the bins
// before and behind it: monotonised central differences (van Leer 1977, eq. 66, on a grid of unequal cells).
//
// Each pixel of a column does all of this: values are chosen and not branched to, because there are compilers whose time doubles with every
// branch in a loop's body.

// Of a neighbour of which a bin of depth h may be unsure: below so many h, the neighbour's colour counts less and less.
const float LEAST_NEIGHBOUR = 0.01;
// Of a bin whose colours vary by less than this share of their mean square, it is not sure that they vary.
const float ONE_COLOUR = 0.01;

// 1 - exp(-h), without cancelling.
float opacity(float h) {
    float series = h * (1.0 - h * (0.5 - h * (0.16666667 - h * 0.041666667)));
    float whole = 1.0 - exp(-h);
    return h < 0.02 ? series : whole;
}

// What a slope of 1 adds to a bin's light: the integral of (x - h / 2) exp(-x). Its Taylor series where the difference would cancel.
float leaning(float h) {
    float series = 9.645062e-6 - h * 1.1022928e-6;
    series = 0.0027777778 - h * (4.9603175e-4 - h * (7.4404762e-5 - h * series));
    series = -h * h * h * (0.083333333 - h * (0.041666667 - h * (0.0125 - h * series)));
    float whole = (1.0 - 0.5 * h) * (1.0 - exp(-h)) - h * exp(-h);
    return h < 1.0 ? series : whole;
}

// How colours (xyz) change over a bin's optical depth (w); nothing is known of a neighbour whose depth is 0.
vec3 slope_of(vec4 nearer, vec4 bin, vec4 farther) {
    float h = max(bin.w, 1e-30);
    vec2 across = vec2(h + nearer.w, h + farther.w);  // twice the distances of the middles
    vec2 sure = vec2(nearer.w / (nearer.w + LEAST_NEIGHBOUR * h), farther.w / (farther.w + LEAST_NEIGHBOUR * h));
    vec3 before = 2.0 * (bin.xyz - nearer.xyz) / across.x;
    vec3 behind = 2.0 * (farther.xyz - bin.xyz) / across.y;
    before = sure.x > 0.0 ? before : vec3(0.0);
    behind = sure.y > 0.0 ? behind : vec3(0.0);
    vec3 left = mix(behind, before, sure.x);
    vec3 right = mix(before, behind, sure.y);
    vec3 middle = (left * across.y + right * across.x) / (across.x + across.y);
    vec3 most = min(min(abs(left) * across.x, abs(right) * across.y), 2.0 * bin.xyz) / h;
    most *= vec3(greaterThan(left * right, vec3(0.0)));
    return clamp(middle, -most, most);
}

// How much a slope b is believed: where the bin's colours (their mean square: `square`) vary less than it alone would make them, the bin is of a
// few sheets and not of a mixture that changes.
float fade(vec4 bin, float square, vec3 b) {
    float variance = max(square - dot(bin.xyz, bin.xyz), 0.0);
    float own = dot(b, b) * bin.w * bin.w / 24.0;
    float least = ONE_COLOUR * square;
    return variance * variance / max(variance * variance + own * own + least * least, 1e-30);
}
