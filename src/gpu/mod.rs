//! The only place that calls Vulkan, and the only one with unsafe bodies. It knows no effect.

pub mod capabilities;
pub mod debug;
pub mod profiler;
