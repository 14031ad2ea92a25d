//! The blur effect on the CPU, written from its definition and not from the shaders: what tests and the benchmark
//! compare the product with. Clear before fast.

pub mod complete;
pub mod distort;
pub mod dry;
pub mod extent;
pub mod ink;
#[cfg(feature = "cli")]
pub mod passes;
pub mod path;
pub mod raster;
pub mod refine;
pub mod scene;
pub mod spline;
pub mod texture;
pub mod visible;
pub mod watertight;
