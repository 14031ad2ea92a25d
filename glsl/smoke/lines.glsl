// Lines. Of a pixel: above 0 the strength of an inner one, up to 1, or, until its ink is told, the height of its step.
const float SILHOUETTE = -1.0;

// Heights of steps, in units of depth.
const float LINE_STEP = 1.0;    // higher ones are ink
const float LOWEST_STEP = 0.4;  // higher ones are where they go on from ink
const float FULL_STEP = 2.0;    // from here on lines have their full width
