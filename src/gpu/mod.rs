//! The only place that calls Vulkan, and the only one with unsafe bodies. It knows no effect.

pub mod capabilities;
pub mod debug;
#[cfg(feature = "cli")]
pub mod headless;
pub mod profiler;
