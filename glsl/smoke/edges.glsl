// What covers a pixel in part.
struct Edge {
    uvec2 colour;  // four halves: linear RGB, premultiplied by the share that is covered, and that share
    float depth;   // view depth, metres
    uint unused;
};

vec4 colour_of(Edge edge) {
    return vec4(unpackHalf2x16(edge.colour.x), unpackHalf2x16(edge.colour.y));
}
