// What is behind everything at a pixel: a colour, or an image.
vec4 background_at(ivec2 pixel) {
    return params.has_background_image != 0u ? texelFetch(background_image, pixel, 0) : params.background;
}
