// Pixels of the picture, row by row.
#ifndef BLUR_PICTURE
#define BLUR_PICTURE

bool is_in_picture(ivec2 at) {
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(params.size)));
}

uint index_of(ivec2 pixel) {
    return uint(pixel.y) * params.size.x + uint(pixel.x);
}

#endif
