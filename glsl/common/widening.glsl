// Metres that a slope of 1 has at a view depth, with what `params` says of the view: orthographic views have metres for slopes.
#ifndef WIDENING
#define WIDENING

float widening(float depth) {
    return params.is_orthographic != 0u ? 1.0 : depth;
}

#endif
