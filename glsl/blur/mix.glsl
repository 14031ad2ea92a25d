// What is made of the colours of frames i and i + 1 at a time between them: with CHOOSES one of the two, so that none is a third.
vec4 mixture(vec4 previous, vec4 next, float moved) {
    float later = clamp(moved, 0.0, 1.0);
    vec4 both = (1.0 - later) * previous + later * next;
    vec4 nearer = later >= 0.5 ? next : previous;
    return CHOOSES != 0u ? nearer : both;
}
