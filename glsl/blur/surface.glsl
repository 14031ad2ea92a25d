// What the mesh covers a pixel with, for those that draw something behind it. The host shares it between effects.
#include "common/half.glsl"
#include "depths.glsl"
#include "picture.glsl"
layout(std430, binding = 26) writeonly buffer Surface { Covering surface[]; };

const float FRONT = 0.98;  // share of its depth that what is nearest has at least of that of what belongs to it

// Where other things than the mesh are seen of an image, if that can be told.
bool is_beside(ivec2 pixel);
vec4 next_at(ivec2 pixel);
float nearness_at(ivec2 at);

// Which of a pixel's samples belong to the nearest.
vec4 front_of(vec4 seen, float nearest) {
    vec4 front;
    for (int i = 0; i < 4; ++i) {
        front[i] = is_before(nearest, seen[i], FRONT) ? 0.0 : 1.0;
    }
    return front;
}

void covers(uint index, vec4 colour, float nearest, float behind) {
    vec4 kept = clamp(colour, vec4(0.0), vec4(vec3(MOST_HALF), 1.0));
    surface[index] = Covering(uvec2(packHalf2x16(kept.xy), packHalf2x16(kept.zw)), depth_of(nearest), behind);
}

// The mesh's part of a pixel of image i + 1, of which so much is covered: the rest is as beside it.
vec4 part_of_next(ivec2 pixel, float covered) {
    vec4 own = next_at(pixel);
    vec4 beside = vec4(0.0);
    float count = 0.0;
    for (int i = 0; i < 9; ++i) {
        ivec2 other = pixel + ivec2(i % 3, i / 3) - 1;
        if (covered < 1.0 && is_in_picture(other) && is_beside(other)) {
            beside += next_at(other);
            count += 1.0;
        }
    }
    return count > 0.0 ? max(own - (1.0 - covered) * beside / count, vec4(0.0)) : covered * own;
}

// Whether none of a pixel's four samples sees the mesh.
bool is_empty(ivec2 pixel) {
    float nearest = 0.0;
    for (int i = 0; i < 4; ++i) {
        nearest = max(nearest, nearness_at(sample_of(pixel, i)));
    }
    return nearest == 0.0;
}
