// Improved noise (Perlin 2002): gradients towards the edges of a cube, fifth-degree fade. Zero at lattice points, period 256.
const uint PERMUTATION[64] = uint[](
    0x5b89a097u, 0x0d830f5au, 0x35605fc9u, 0xe107e9c2u, 0x1e67248cu, 0x63088e45u, 0x0a15f025u, 0x9406be17u,
    0x4bea78f7u, 0x3ec51a00u, 0xcbdbfc5eu, 0x200b2375u, 0x5821b139u, 0x573895edu, 0x887d14aeu, 0xaf44a8abu,
    0x8647a54au, 0xa61b308bu, 0xe79e924du, 0x7ae56f53u, 0xe685d33cu, 0x295c69dcu, 0x28f52e37u, 0x368f66f4u,
    0xa13f1941u, 0x4950d801u, 0xbb844cd1u, 0xa91259d0u, 0x8287c4c8u, 0x569fbc74u, 0xc66d64a4u, 0x4003baadu,
    0xfae2d934u, 0xca057b7cu, 0x7e769326u, 0xd45552ffu, 0xe33bcecfu, 0x113a102fu, 0x2a1cbdb6u, 0xd5aab7dfu,
    0x0298f877u, 0x46a39a2cu, 0x9b6599ddu, 0x09ac2ba7u, 0xfd271681u, 0x6e6c6213u, 0xe8e0714fu, 0x6870b9b2u,
    0xe461f6dau, 0xc1f222fbu, 0x0c90d2eeu, 0xf1a2b3bfu, 0xeb913351u, 0x6bef0ef9u, 0x1fd6c031u, 0x9d6ac7b5u,
    0xb0cc54b8u, 0x2d327973u, 0xfe96047fu, 0x5dcdec8au, 0x1d4372deu, 0x8df34818u, 0x424ec380u, 0xb49c3dd7u
);

uint permuted(uint i) {
    i &= 255u;
    return PERMUTATION[i >> 2u] >> (8u * (i & 3u)) & 255u;
}

float fade(float t) {
    precise float value = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    return value;
}

float gradient(uint h, vec3 p) {
    h &= 15u;
    float u = h < 8u ? p.x : p.y;
    float v = h < 4u ? p.y : h == 12u || h == 14u ? p.x : p.z;
    return ((h & 1u) == 0u ? u : -u) + ((h & 2u) == 0u ? v : -v);
}

float between(float t, float a, float b) {
    precise float value = a + t * (b - a);
    return value;
}

float noise(vec3 p) {
    vec3 low = floor(p);
    uvec3 cell = uvec3(ivec3(low)) & 255u;
    vec3 at = p - low;
    vec3 f = vec3(fade(at.x), fade(at.y), fade(at.z));
    uint a = permuted(cell.x) + cell.y;
    uint b = permuted(cell.x + 1u) + cell.y;
    uvec4 corner = uvec4(permuted(a), permuted(a + 1u), permuted(b), permuted(b + 1u)) + cell.z;
    float slices[2];
    for (uint z = 0u; z < 2u; ++z) {
        float back = float(z);
        float low_y = between(f.x, gradient(permuted(corner.x + z), at - vec3(0.0, 0.0, back)),
                              gradient(permuted(corner.z + z), at - vec3(1.0, 0.0, back)));
        float high_y = between(f.x, gradient(permuted(corner.y + z), at - vec3(0.0, 1.0, back)),
                               gradient(permuted(corner.w + z), at - vec3(1.0, 1.0, back)));
        slices[z] = between(f.y, low_y, high_y);
    }
    return between(f.z, slices[0], slices[1]);
}
