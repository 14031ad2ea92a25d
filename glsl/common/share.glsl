// Where an effect writes its motion vector: upscalers want that of what makes up most of a pixel.
const float LEAST_SHARE = 0.5;  // of a pixel that shows the effect
