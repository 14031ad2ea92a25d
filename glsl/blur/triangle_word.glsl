// What a triangle's last word says.
#ifndef TRIANGLE_WORD
#define TRIANGLE_WORD

// Its surface: what an object has of one material.
uint surface_of(uint word) {
    return word >> SURFACE_SHIFT & MOST_SURFACE;
}

#endif
