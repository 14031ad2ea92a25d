// Pixels of the picture, and four samples a pixel, as those of a picture that is twice as large; row by row.
#ifndef BLUR_PICTURE
#define BLUR_PICTURE

bool is_in_picture(ivec2 at) {
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(params.size)));
}

uint index_of(ivec2 pixel) {
    return uint(pixel.y) * params.size.x + uint(pixel.x);
}

// One of a pixel's four samples, 0 to 3.
ivec2 sample_of(ivec2 pixel, int i) {
    return 2 * pixel + ivec2(i & 1, i >> 1);
}

uint index_of_sample(ivec2 at) {
    return uint(at.y) * 2u * params.size.x + uint(at.x);
}

#endif
