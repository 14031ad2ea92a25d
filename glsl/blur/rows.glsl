// Rows of parts that are found on the device; after directions.glsl.
const uint MOST_ROWS = DIRECTIONS;  // of a part

uint rows_of(Cluster cluster) {
    return cluster.bounds_end - cluster.bounds_begin;
}
