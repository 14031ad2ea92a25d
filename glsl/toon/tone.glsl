// Share of a tone that begins at `from` in a pixel of a value. `width`: how much the value changes over the border; 0: it is hard.
float tone_share(float value, float from, float width) {
    float above = value - from;
    return width > 0.0 ? clamp(0.5 + above / width, 0.0, 1.0) : above >= 0.0 ? 1.0 : 0.0;
}
