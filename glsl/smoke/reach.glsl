// Groups within the Gaussian's window of a block, a bit each, equal modulo 32.
struct Reach {
    uint beside;  // to the left and right
    uint above;   // above and below
};
