// Limits of what effects take.
#ifndef LIMITS
#define LIMITS
const float FARTHEST = 1e12;  // largest coordinate that is taken, in metres: its square and cube are finite as single floats
#endif
