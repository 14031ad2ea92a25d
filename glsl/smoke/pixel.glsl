// A pixel's group and luminance travel in one word: luminance as 24-bit fixed point (3e-8, exact in a float), id below.
#include "group.glsl"

const float LUMINANCE_ONE = 16777215.0;  // the largest

uint pack_pixel(float luminance, uint id) {
    // Rounding carries 1 to 2^24, which has no room.
    return min(uint(clamp(luminance, 0.0, 1.0) * LUMINANCE_ONE + 0.5), uint(LUMINANCE_ONE)) << GROUP_BITS | id;
}

float pixel_luminance(uint pixel) {
    return float(pixel >> GROUP_BITS) / LUMINANCE_ONE;
}

uint pixel_id(uint pixel) {
    return pixel & GROUP_MASK;
}
