// Textures of drawn frames, in the rows behind the base colours: for each triangle two, (u, v) of its corners and the number
// of its texture; for each texture two; then texels. After toon.glsl, with `clip`.
const uint TRIANGLE_ROWS = 2u;
const uint TEXTURE_ROWS = 2u;
const uint REPEATED = 0u;      // how a texture goes on beyond its edges
const uint MIRRORED = 1u;
const uint CLAMPED = 2u;
const uint TEXEL_BITS = 10u;   // of the square root of each channel
const uint TEXEL_MASK = 1023u;
const uint NEAREST = 16u;      // a bit of how a texture is looked up: magnified, its texels are squares

// Levels of a texture follow each other, each half as large as the one before.
struct Texture {
    uint begin;    // of its texels, in words from the first row
    uvec2 size;    // of the largest level
    uint levels;
    uvec2 wrap;    // across and down
    bool is_nearest;
};

uvec4 texture_row(uint row) {
    return floatBitsToUint(base_colours[row]);
}

Texture texture_of(uint number) {
    uint row = (3u + TRIANGLE_ROWS) * params.triangles + TEXTURE_ROWS * number;
    uvec4 first = texture_row(row);
    uvec4 second = texture_row(row + 1u);
    return Texture(first.x, first.yz, first.w, second.xy, (second.z & NEAREST) != 0u);
}

int wrapped(int at, int size, uint wrap) {
    if (wrap == CLAMPED) {
        return clamp(at, 0, size - 1);
    }
    int period = wrap == MIRRORED ? 2 * size : size;
    int within = at - period * int(floor(float(at) / float(period)));
    within = clamp(within, 0, period - 1);
    return within < size ? within : period - 1 - within;
}

vec3 texel_at(Texture map, uint begin, ivec2 size, ivec2 at) {
    ivec2 place = ivec2(wrapped(at.x, size.x, map.wrap.x), wrapped(at.y, size.y, map.wrap.y));
    uint word = begin + uint(place.y * size.x + place.x);
    uint texel = texture_row(word / 4u)[word % 4u];
    vec3 root = vec3(uvec3(texel, texel >> TEXEL_BITS, texel >> (2u * TEXEL_BITS)) & TEXEL_MASK) / float(TEXEL_MASK);
    return root * root;
}

vec3 level_at(Texture map, uint level, vec2 place, bool is_nearest) {
    uint begin = map.begin;
    uvec2 size = map.size;
    for (uint above = 0u; above < level; ++above) {
        begin += size.x * size.y;
        size = max(size / 2u, uvec2(1u));
    }
    vec2 texels = place * vec2(size);
    if (is_nearest) {
        return texel_at(map, begin, ivec2(size), ivec2(floor(texels)));
    }
    vec2 corner = floor(texels - 0.5);
    vec2 share = texels - 0.5 - corner;
    ivec2 at = ivec2(corner);
    vec3 above = mix(texel_at(map, begin, ivec2(size), at), texel_at(map, begin, ivec2(size), at + ivec2(1, 0)), share.x);
    vec3 below = mix(texel_at(map, begin, ivec2(size), at + ivec2(0, 1)), texel_at(map, begin, ivec2(size), at + 1), share.x);
    return mix(above, below, share.y);
}

// What a triangle's texture is at a place of it that a sample of a frame sees; white without one.
vec3 texture_at(uint frame, uint index, uvec4 triangle, vec3 barycentrics) {
    uint row = 3u * params.triangles + TRIANGLE_ROWS * index;
    vec4 first = base_colours[row];
    vec4 second = base_colours[row + 1u];
    uint number = floatBitsToUint(second.z);
    if (number == NONE) {
        return vec3(1.0);
    }
    Texture map = texture_of(number);
    vec2 place = barycentrics.x * first.xy + barycentrics.y * first.zw + barycentrics.z * second.xy;
    uint corner = frame * params.points;
    vec3 a = clip[corner + triangle.x].xyz;
    vec3 b = clip[corner + triangle.y].xyz;
    vec3 c = clip[corner + triangle.z].xyz;
    vec3 widths = vec3(widening(a.z), widening(b.z), widening(c.z));
    float volume = abs(dot(vec3(a.xy, widths.x), cross(vec3(b.xy, widths.y), vec3(c.xy, widths.z))));
    float width = dot(barycentrics, widths);
    vec2 extent = vec2(map.size);
    float area = abs(cross2((first.zw - first.xy) * extent, (second.xy - first.xy) * extent));
    // Texels of a sample, of which a pixel has four.
    float density = 0.25 * area * (width * width * width) / max(volume, 1e-30);
    float level = clamp(0.5 * log2(max(density, 1e-12)), 0.0, float(map.levels - 1u));
    uint upper = uint(level);
    bool is_nearest = map.is_nearest && level == 0.0;
    vec3 fine = level_at(map, upper, place, is_nearest);
    if (level == float(upper)) {
        return fine;
    }
    return mix(fine, level_at(map, upper + 1u, place, false), level - float(upper));
}
