// A pixel's group and luminance travel in one word: luminance as 24-bit fixed point (3e-8, exact in a float), id below.
const float LUMINANCE_ONE = 16777215.0;

uint pack_pixel(float luminance, uint id) {
    // Rounding carries 1 to 2^24, which has no room.
    return min(uint(clamp(luminance, 0.0, 1.0) * LUMINANCE_ONE + 0.5), uint(LUMINANCE_ONE)) << 8 | id;
}

float pixel_luminance(uint pixel) {
    return float(pixel >> 8) / LUMINANCE_ONE;
}

uint pixel_id(uint pixel) {
    return pixel & 255u;
}
