// Tables of colours by world normal: bins of the octahedral map.
#ifndef BLUR_BINS
#define BLUR_BINS

const uint SIDE = 32u;             // bins along each side
const uint BINS = SIDE * SIDE;
const uint BIN_FIELDS = 9u;        // words of a bin's sums: pixels; low words of four channels; high words of these
const float UNITS = 65536.0;       // of a channel, of the frame's scale
const float LARGEST_SCALE = 16.0;  // of a frame: channels above it are clamped

#endif
