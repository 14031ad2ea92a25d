// The clusters that a host's parts make up: outline, number of points that move, and of teeth.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "params.glsl"
#include "velocity_sums.glsl"
#include "rows.glsl"
layout(local_size_x = DIRECTIONS) in;
layout(std430, binding = 1) readonly buffer PartRows { PartRow part_rows[]; };
layout(std430, binding = 2) readonly buffer ChunkSums { vec4 chunk_sums[]; };
layout(std430, binding = 3) readonly buffer SupportPoints { uint support_points[]; };
layout(std430, binding = 4) readonly buffer Motions { PointMotion motions[]; };
layout(std430, binding = 5) writeonly buffer Bounds { vec2 bounds[]; };
layout(std430, binding = 6) writeonly buffer Clusters { Cluster clusters[]; };
layout(push_constant) uniform DescribeConstants {
    uint teeth;      // random numbers across each; 0: by its width
    uint most_teeth;
    float tooth;     // width of one, in pixels
    float row;       // from a row to the next, in pixels, at most; 0: parts have none
} constants;

shared vec3 least[DIRECTIONS];
shared vec3 most[DIRECTIONS];

vec4 summed(PartRow part, uint lane) {
    vec4 sum = vec4(0.0);
    for (uint i = part.first_chunk + lane; i < part.last_chunk; i += DIRECTIONS) {
        sum = join_velocities(sum, chunk_sums[i]);
    }
    return sum_velocities(sum, lane);
}

// How wide the outline is along three directions, of which two are x and y.
vec3 widths(vec2 place, vec2 across, uint lane) {
    vec3 along = vec3(dot(across, place), place);
    least[lane] = along;
    most[lane] = along;
    barrier();
    for (uint half_way = DIRECTIONS / 2u; half_way > 0u; half_way >>= 1u) {
        if (lane < half_way) {
            least[lane] = min(least[lane], least[lane + half_way]);
            most[lane] = max(most[lane], most[lane + half_way]);
        }
        barrier();
    }
    return most[0] - least[0];
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint at = gl_GlobalInvocationID.x;
    PartRow part = part_rows[gl_WorkGroupID.x];
    uint point = support_points[at];
    vec2 place = vec2(0.0);
    if (point != NONE) {
        place = motions[point].position;
    }
    vec4 sum = summed(part, lane);
    vec2 mean = sum.w > 0.0 ? sum.xy / sum.w : vec2(0.0);
    float speed = length(mean);
    float mean_speed = sum.z / max(sum.w, 1.0);
    bool has_mean = speed > 0.0 && speed >= NO_MEAN * mean_speed;
    bool has_rows = has_mean && constants.row > 0.0 && speed >= COMMON * mean_speed;
    vec2 ahead = has_mean ? mean / speed : vec2(0.0);
    vec3 width = widths(place, vec2(ahead.y, -ahead.x), lane);
    if (!has_rows) {
        bounds[at] = place;
    }
    if (lane == 0u) {
        float teeth = round((has_mean ? width.x : max(width.y, width.z)) / constants.tooth) + 1.0;
        uint count = constants.teeth > 0u ? constants.teeth : uint(clamp(teeth, 2.0, float(constants.most_teeth)));
        uint begin = gl_WorkGroupID.x * DIRECTIONS;
        uint rows = min(uint(min(ceil(width.x / constants.row), 1e6)) + 1u, MOST_ROWS);
        rows = width.x < LEAST_EXTENT ? 1u : rows;
        clusters[gl_WorkGroupID.x] =
            Cluster(part.object, begin, begin + (has_rows ? rows : DIRECTIONS), count, uint(sum.w), least[0].x,
                    has_rows ? ahead : vec2(0.0), width.x, 0u);
    }
}
