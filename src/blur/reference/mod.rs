//! The blur effect on the CPU, written from its definition and not from the shaders: what tests and the benchmark
//! compare the product with. Clear before fast.

pub mod extent;
pub mod path;
pub mod refine;
pub mod spline;
pub mod watertight;
