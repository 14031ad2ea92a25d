// Share of a line of a width that a place has from one which is so far from it: the line fades over the last step.
float ink_share(float width, float way) {
    return clamp(width - way, 0.0, 1.0);
}
