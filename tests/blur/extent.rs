//! k, l, k' and smoothing against f32 brute force, bit for bit on drivers whose divisions and roots are exact.
