//! What the CPU references of the effects share. For tests and the benchmark, not for hosts.

pub mod noise;
pub mod random;
