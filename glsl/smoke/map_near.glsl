// Distance from a point light at which its shadow map's depth is 1.
float map_near() {
    return 1e-3 * params.smallest_side;
}
