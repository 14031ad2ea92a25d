// What the host tells the kernels of the vignette.
#ifndef VIGNETTE_PARAMS
#define VIGNETTE_PARAMS

layout(binding = 0) uniform VignetteParams {
    uvec2 size;     // of the picture in pixels
    uvec2 corner;   // of the picture, in the target
    float strength; // darkness of the corners, 0 to 1
    float radius;   // where it begins, as a share of the way from the centre to a corner
};

#endif
