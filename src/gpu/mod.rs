//! The only place that calls Vulkan. Knows no effect.

pub mod buffer;
pub mod capabilities;
pub mod debug;
pub mod image;
pub mod kernel;
pub mod profiler;
pub mod raster;
pub mod recorder;
pub mod resources;
