#ifndef HALF
#define HALF
const float MOST_HALF = 65504.0;  // the largest finite number in half precision
#endif
