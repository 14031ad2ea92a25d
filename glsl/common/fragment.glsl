// Where a fragment is.
#ifndef COMMON_FRAGMENT
#define COMMON_FRAGMENT

// Its pixel in a picture of `size` that begins at `corner`. Fragments beside the picture, which make up whole quads, show nothing
// and are given the last row or column, so that what they read is there.
uvec2 pixel_of(vec2 at, uvec2 corner, uvec2 size) {
    return min(uvec2(at) - corner, size - 1u);
}

#endif
