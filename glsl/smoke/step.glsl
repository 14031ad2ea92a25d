// Steps in depth, in units of lines.
const float LINE_STEP = 1.0;    // higher ones are ink
const float LOWEST_STEP = 0.4;  // higher ones are where they go on from ink
const float FULL_STEP = 2.0;    // from here on lines have their full width
