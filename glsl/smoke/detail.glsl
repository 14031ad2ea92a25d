// Weights of the Gaussian of the density. An invocation smooths voxels that are neighbours along an axis together: as it walks
// along the axis, what a voxel weighs in the first of them it weighs in the second one step later, so each weight is read once.

float detail_weight(int distance, int axis) {
    uint far = uint(abs(distance));
    return far <= params.detail_window[axis] ? params.detail_weights[min(far, MOST_DETAIL_WINDOW)][axis] : 0.0;
}

// Weights in eight neighbours.
struct RunWeights {
    vec4 low;
    vec4 high;
};

RunWeights stepped(RunWeights weights, float first) {
    return RunWeights(vec4(first, weights.low.xyz), vec4(weights.low.w, weights.high.xyz));
}
