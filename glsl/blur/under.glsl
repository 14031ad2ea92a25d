// What a frame that is drawn lies over, for passes that also run where nothing else of the frame's parameters is there.
layout(push_constant) uniform BackgroundConstants {
    vec4 background;
    uint has_image;  // 1: it is an image
    uvec2 corner;    // of the picture, in the target
} constants;

vec4 over_background(vec4 own, ivec2 pixel) {
    vec4 background = constants.has_image != 0u ? texelFetch(background_image, pixel, 0) : constants.background;
    return own + (1.0 - own.a) * background;
}
