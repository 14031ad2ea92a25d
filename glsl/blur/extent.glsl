// How far ahead and how far to the side a vertex is among those of its cluster. The extremes of a linear function lie on
// the convex hull, and the products of its points are those of brute force: the result is the same to the bit.
#include "../common/random.glsl"

const uint FEW = 48u;        // points of a chain that are all looked at
const uint MOST_WALK = 128u; // of longer ones, before they are all looked at after all
const uint FEW_NEAR = 64u;   // points near a chain, if it is not all looked at

float along(vec2 d, vec2 q) {
    precise float p = d.x * q.x + d.y * q.y;
    return p;
}

// Increases as a vector turns from x to y, 0 to 4.
float turn_of(vec2 v) {
    float p = v.y / (abs(v.x) + abs(v.y));
    return v.x < 0.0 ? 2.0 - p : v.y < 0.0 ? 4.0 + p : p;
}

float turn_from(float start, vec2 v) {
    float turn = turn_of(v) - start;
    return turn < 0.0 ? turn + 4.0 : turn;
}

// The largest product over a hull, or infinity if it took too long to find.
//
// Along a convex outline products rise to the largest and fall again, but for their rounding. From any of its points it is
// thus found by walking both ways until products are less than the largest so far by more than rounding could have done;
// that the walk starts near the largest only makes it short.
float farthest(Cluster cluster, vec2 d) {
    uint first = cluster.hull_begin;
    uint count = cluster.chain_end - first;
    float start = turn_of(hull[first + 1u] - hull[first]);
    float wanted = turn_from(start, vec2(-d.y, d.x));
    uint low = 0u;
    uint high = count;
    while (low < high) {
        uint middle = (low + high) / 2u;
        uint next = middle + 1u == count ? 0u : middle + 1u;
        if (turn_from(start, hull[first + next] - hull[first + middle]) < wanted) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    uint at = low % count;
    float best = along(d, hull[first + at]);
    uint forward = at;
    uint steps = 0u;
    for (; steps < MOST_WALK; ++steps) {
        forward = forward + 1u == count ? 0u : forward + 1u;
        float p = along(d, hull[first + forward]);
        best = max(best, p);
        if (p < best - params.lens.z) {
            break;
        }
    }
    uint back = at;
    for (; steps < MOST_WALK; ++steps) {
        back = back == 0u ? count - 1u : back - 1u;
        float p = along(d, hull[first + back]);
        best = max(best, p);
        if (p < best - params.lens.z) {
            break;
        }
    }
    for (uint i = cluster.chain_end; i < cluster.hull_end; ++i) {
        best = max(best, along(d, hull[i]));
    }
    return steps < MOST_WALK ? best : uintBitsToFloat(0x7f800000u);
}

// (smallest, largest) product along d and across it.
vec4 extremes(Cluster cluster, vec2 d, vec2 u) {
    if (cluster.chain_end - cluster.hull_begin > FEW && cluster.hull_end - cluster.chain_end <= FEW_NEAR) {
        vec4 found = vec4(0.0);
        // A loop, because compilers would copy the search to each of its calls.
        for (uint i = 0u; i < 4u; ++i) {
            vec2 way = i < 2u ? d : u;
            found[i] = farthest(cluster, (i & 1u) == 0u ? -way : way);
        }
        if (max(max(found.x, found.y), max(found.z, found.w)) < uintBitsToFloat(0x7f800000u)) {
            return vec4(-found.x, found.y, -found.z, found.w);
        }
    }
    vec2 q = hull[cluster.hull_begin];
    vec4 found = vec4(vec2(along(d, q)), vec2(along(u, q)));
    for (uint i = cluster.hull_begin + 1u; i < cluster.hull_end; ++i) {
        q = hull[i];
        float ahead = along(d, q);
        float aside = along(u, q);
        found.xz = min(found.xz, vec2(ahead, aside));
        found.yw = max(found.yw, vec2(ahead, aside));
    }
    return found;
}

// k and l.
vec2 extent_of(vec4 motion, uint label) {
    vec2 x = motion.xy;
    vec2 v = motion.zw;
    precise float speed2 = v.x * v.x + v.y * v.y;
    if (label == 0u || !(speed2 >= 1e-12)) {
        return vec2(1.0, 0.0);
    }
    precise float speed = sqrt(speed2);
    precise float inverse = 1.0 / speed;
    precise vec2 d = vec2(v.x * inverse, v.y * inverse);
    vec2 u = vec2(d.y, -d.x);
    vec4 found = extremes(clusters[label - 1u], d, u);
    precise vec2 ahead = found.xy - along(d, x);
    precise vec2 aside = found.zw - along(u, x);
    precise float k_length = ahead.y - ahead.x;
    precise float l_length = aside.y - aside.x;
    precise float k = -ahead.x / k_length;
    precise float l = -aside.x / l_length;
    return vec2(k_length < 1e-3 ? 1.0 : clamp(k, 0.0, 1.0), l_length < 1e-3 ? 0.0 : clamp(l, 0.0, 1.0));
}

float tooth(Cluster cluster, uint index) {
    return unit(hash(params.image.z, cluster.object, index, params.image.w));
}

// k' of a vertex by itself.
float moved_by(vec2 extent, uint label) {
    if (label == 0u) {
        return 1.0;
    }
    Cluster cluster = clusters[label - 1u];
    float r;
    if (cluster.teeth < 2u) {
        r = tooth(cluster, 0u);
    } else {
        precise float x = float(cluster.teeth - 1u) * extent.y;
        uint index = min(uint(x), cluster.teeth - 2u);
        float from = tooth(cluster, index);
        precise float mixed = from + (x - float(index)) * (tooth(cluster, index + 1u) - from);
        r = mixed;
    }
    precise float moved = 1.0 - params.model.x * (1.0 - extent.x) * r;
    return moved;
}

// 1 - k' as smoothing has it.
uint whole_of(float moved) {
    precise float whole = (1.0 - moved) * UNIT + 0.5;
    return uint(whole);
}

// k' with what smoothing adds, within the range that k' has.
float shifted(float moved, float added) {
    precise float sum = moved + added;
    precise float least = 1.0 - params.model.x;
    return min(max(sum, least), 1.0);
}
