// How far ahead and how far to the side a vertex is in its cluster: in its row of it, or among all of its points. The extremes of
// a linear function lie on the convex hull, and the products of its points are those of brute force: the result is the same
// to the bit.
#include "../common/random.glsl"
#include "along.glsl"
#include "directions.glsl"

#ifndef MOST_SCANNED
#define MOST_SCANNED 65536u  // points of a hull, that can be all looked at
#endif
const float LEAST_SPEED_SQUARED = 1e-12;  // (pixels a frame)^2: what is slower has no direction
const uint FEW = 48u;          // points of a hull that are all looked at
const uint MOST_WALK = 256u;   // of larger ones, before they are all looked at after all
const uint AHEAD = 65536u;     // where the teeth of what smears ahead begin
const uint CHORDS = 1024u;     // directions of a hull are those from each point to one that is so small a part farther on

float turn_from(float start, vec2 v) {
    float turn = turn_of(v) - start;
    return turn < 0.0 ? turn + 4.0 : turn;
}

// The largest product over a hull; whether it has been found for certain.
//
// A hull's points are in the order of the outline, none of them farther from it than rounding of products. Along a convex
// outline products rise to the largest and fall again. From any of its points it is thus found by walking both ways until
// products are less than the largest so far by more than rounding and distance from the outline could have done; that the
// walk starts near the largest only makes it short.
bool farthest(Cluster cluster, vec2 d, out float best) {
    uint first = cluster.bounds_begin;
    uint count = cluster.bounds_end - first;
    uint reach = 1u + count / CHORDS;
    float start = turn_of(bounds[first + reach] - bounds[first]);
    float wanted = turn_from(start, vec2(-d.y, d.x));
    uint low = 0u;
    uint high = count;
    while (low < high) {
        uint middle = (low + high) / 2u;
        uint next = middle + reach < count ? middle + reach : middle + reach - count;
        if (turn_from(start, bounds[first + next] - bounds[first + middle]) < wanted) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    uint at = (low + reach / 2u) % count;
    best = along(d, bounds[first + at]);
    uint forward = at;
    uint steps = 0u;
    for (; steps < MOST_WALK; ++steps) {
        forward = forward + 1u == count ? 0u : forward + 1u;
        float p = along(d, bounds[first + forward]);
        best = max(best, p);
        if (p < best - params.hull_margin) {
            break;
        }
    }
    uint back = at;
    for (; steps < MOST_WALK; ++steps) {
        back = back == 0u ? count - 1u : back - 1u;
        float p = along(d, bounds[first + back]);
        best = max(best, p);
        if (p < best - params.hull_margin) {
            break;
        }
    }
    return steps < MOST_WALK;
}

void widen(inout vec4 found, vec2 d, vec2 u, uint at) {
    vec2 q = bounds[at];
    float ahead = along(d, q);
    float aside = along(u, q);
    found.xz = min(found.xz, vec2(ahead, aside));
    found.yw = max(found.yw, vec2(ahead, aside));
}

void widen_by_four(inout vec4 found, vec2 d, vec2 u, uint at) {
    widen(found, d, u, at);
    widen(found, d, u, at + 1u);
    widen(found, d, u, at + 2u);
    widen(found, d, u, at + 3u);
}

// The largest product over a hull that has the farthest point in each of many directions. Around that of the nearest of them
// are those of its neighbours; one between, which none of them has, is farther by less than LARGEST_STEP / 4 of their distance.
float farthest_of_directions(Cluster cluster, vec2 d) {
    uint nearest = nearest_direction(d);
    float best = along(d, bounds[cluster.bounds_begin + nearest]);
    best = max(best, along(d, bounds[cluster.bounds_begin + (nearest + 1u) % DIRECTIONS]));
    return max(best, along(d, bounds[cluster.bounds_begin + (nearest + DIRECTIONS - 1u) % DIRECTIONS]));
}

// (smallest, largest) product along d and across it. Of hulls with more than MOST_SCANNED points, too many of which are
// equally far for a walk, one of these.
vec4 extremes(Cluster cluster, vec2 d, vec2 u) {
    if (params.has_directions != 0u) {
        return vec4(-farthest_of_directions(cluster, -d), farthest_of_directions(cluster, d),
                    -farthest_of_directions(cluster, -u), farthest_of_directions(cluster, u));
    }
    uint count = cluster.bounds_end - cluster.bounds_begin;
    if (count > FEW) {
        vec4 found = vec4(0.0);
        bool is_certain = true;
        // A loop, because compilers would copy the search to each of its calls.
        for (uint i = 0u; i < 4u; ++i) {
            vec2 way = i < 2u ? d : u;
            float most;
            is_certain = farthest(cluster, (i & 1u) == 0u ? -way : way, most) && is_certain;
            found[i] = most;
        }
        if (is_certain || count > MOST_SCANNED) {
            return vec4(-found.x, found.y, -found.z, found.w);
        }
    }
    vec2 q = bounds[cluster.bounds_begin];
    vec4 found = vec4(vec2(along(d, q)), vec2(along(u, q)));
    uint i = cluster.bounds_begin + 1u;
    // Sixteen an iteration, because iterations are counted.
    for (; i + 16u <= cluster.bounds_end; i += 16u) {
        widen_by_four(found, d, u, i);
        widen_by_four(found, d, u, i + 4u);
        widen_by_four(found, d, u, i + 8u);
        widen_by_four(found, d, u, i + 12u);
    }
    for (; i < cluster.bounds_end; ++i) {
        widen(found, d, u, i);
    }
    return found;
}

// The direction of a velocity; whether it has one.
bool direction_of(vec2 v, out vec2 d) {
    precise float speed2 = v.x * v.x + v.y * v.y;
    precise float speed = sqrt(speed2);
    precise float inverse = 1.0 / speed;
    precise vec2 unit_vector = vec2(v.x * inverse, v.y * inverse);
    d = unit_vector;
    return speed2 >= LEAST_SPEED_SQUARED;
}

// k and l of a point among the extremes of its cluster.
vec2 shares_of(vec4 found, vec2 x, vec2 d, vec2 u) {
    precise vec2 ahead = found.xy - along(d, x);
    precise vec2 aside = found.zw - along(u, x);
    precise float k_length = ahead.y - ahead.x;
    precise float l_length = aside.y - aside.x;
    precise float k = -ahead.x / k_length;
    precise float l = -aside.x / l_length;
    return vec2(k_length < LEAST_EXTENT ? 1.0 : clamp(k, 0.0, 1.0), l_length < LEAST_EXTENT ? 0.0 : clamp(l, 0.0, 1.0));
}

// k and l of a point of a cluster with rows: between the rear and the front of where it is across.
vec2 shares_of_rows(Cluster cluster, vec2 x) {
    uint last = cluster.bounds_end - cluster.bounds_begin - 1u;
    precise float aside = along(vec2(cluster.ahead.y, -cluster.ahead.x), x) - cluster.aside;
    precise float across = aside / cluster.width;
    float l = cluster.width < LEAST_EXTENT ? 0.0 : clamp(across, 0.0, 1.0);
    precise float row = l * float(last);
    uint index = min(uint(row), max(last, 1u) - 1u);
    vec2 from = bounds[cluster.bounds_begin + index];
    vec2 to = bounds[cluster.bounds_begin + min(index + 1u, last)];
    precise vec2 bound = from + (row - float(index)) * (to - from);
    precise float k_length = bound.y - bound.x;
    precise float k = (along(cluster.ahead, x) - bound.x) / k_length;
    return vec2(k_length < LEAST_EXTENT ? 1.0 : clamp(k, 0.0, 1.0), l);
}

// k and l.
vec2 extent_of(vec2 position, vec2 velocity, uint label) {
    vec2 d;
    if (label == 0u || !direction_of(velocity, d)) {
        return vec2(1.0, 0.0);
    }
    Cluster cluster = clusters[label - 1u];
    if (cluster.ahead != vec2(0.0)) {
        return shares_of_rows(cluster, position);
    }
    vec2 u = vec2(d.y, -d.x);
    return shares_of(extremes(cluster, d, u), position, d, u);
}

// The share of strength that what moves so fast has.
float share_at(vec2 velocity) {
    precise float speed = sqrt(velocity.x * velocity.x + velocity.y * velocity.y);
    float share = 1.0;
    vec2 before = vec2(-1.0);
    for (uint k = 0u; k < params.curve_keys; ++k) {
        vec4 row = params.curve[k / 2u];
        vec2 key = (k & 1u) == 0u ? row.xy : row.zw;
        precise float along = (speed - before.x) / (key.x - before.x);
        precise float mixed = before.y + along * (key.y - before.y);
        bool is_first = k == 0u;
        share = is_first || speed >= key.x ? key.y : speed > before.x ? mixed : share;
        before = key;
    }
    return share;
}

float tooth(Cluster cluster, uint index) {
    return unit(hash(params.seed, cluster.object, index, params.generation));
}

// A random number across a cluster, linear between teeth, of which the first is `first`.
float ragged(Cluster cluster, float l, uint first) {
    if (cluster.teeth < 2u) {
        return tooth(cluster, first);
    }
    precise float x = float(cluster.teeth - 1u) * l;
    uint index = min(uint(x), cluster.teeth - 2u);
    float from = tooth(cluster, first + index);
    precise float mixed = from + (x - float(index)) * (tooth(cluster, first + index + 1u) - from);
    return mixed;
}

// k' of a vertex by itself.
float moved_by(vec2 extent, uint label, float share) {
    if (label == 0u) {
        return 1.0;
    }
    Cluster cluster = clusters[label - 1u];
    precise float strength = params.strength * share;
    precise float moved = 1.0 - strength * (1.0 - extent.x) * ragged(cluster, extent.y, 0u);
    if (params.lead == 0.0) {
        return moved;
    }
    precise float lead = params.lead * share;
    precise float ahead = moved + lead * extent.x * ragged(cluster, extent.y, AHEAD);
    return ahead;
}

// How far before the latest k' there may be a k' is, as smoothing has it.
uint whole_of(float moved) {
    precise float whole = (1.0 + params.lead - moved) * UNIT + 0.5;
    return uint(whole);
}

// k' with what smoothing adds, within the range that k' has.
float shifted(float moved, float added) {
    precise float sum = moved + added;
    precise float least = 1.0 - params.strength;
    return min(max(sum, least), 1.0 + params.lead);
}
