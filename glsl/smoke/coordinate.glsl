// Depth in ranges of the groups: the coordinate of the mask "soft". Between two ranges lies a plane, and one at either end:
// planes 0 to the number of groups. Every pixel belongs to the two planes beside it, more to the nearer one.
#include "group.glsl"

struct Ranges {
    float start;      // of the first, metres
    float per_metre;
};

// A depth in ranges from the start of the first; what is nearer or farther than all of them counts as their end.
float group_coordinate(Ranges ranges, float depth) {
    precise float coordinate = (depth - ranges.start) * ranges.per_metre;
    return clamp(coordinate, 0.0, float(params.group_count));
}

// The range that a depth lies in, as a group: between planes group - 1 and group.
uint group_at(Ranges ranges, float depth) {
    return min(uint(group_coordinate(ranges, depth)), params.group_count - 1u) + 1u;
}

// Shares of a pixel in the planes before and behind it. They add up to 1; one is at least 1/2, so that what a pixel
// itself adds to its sums of weights is at least 1/2, too: the sum of their squares. A group may have been told
// by another kernel, where a depth on a border can round to the other side: it belongs to the border's plane then.
vec2 plane_shares(Ranges ranges, float depth, uint group) {
    float behind = clamp(group_coordinate(ranges, depth) - float(group - 1u), 0.0, 1.0);
    return vec2(1.0 - behind, behind);
}
