//! Buffers, images, pipelines, queries, command buffers: what calls Vulkan. It knows no effect.

pub mod buffer;
pub mod capabilities;
pub mod costs;
pub mod debug;
pub mod executor;
#[cfg(feature = "cli")]
pub mod headless;
pub mod image;
pub mod kernels;
mod module;
pub mod pipelines;
pub mod profiler;
pub mod raster;
pub mod recorder;
pub mod resources;
pub mod scratch;
#[cfg(feature = "cli")]
pub mod transfer;
