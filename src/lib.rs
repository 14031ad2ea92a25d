//! Hand-drawn-looking effects on raw Vulkan.
#![deny(missing_docs, unsafe_op_in_unsafe_fn)]

pub mod barrier;
pub mod blur;
pub mod effect;
pub mod error;
pub mod flame;
pub mod gpu;
pub mod host;
mod layout;
#[doc(hidden)]
pub mod noise;
pub mod plan;
pub mod profile;
#[doc(hidden)]
pub mod random;
pub mod settings;
pub mod shaders;
pub mod smoke;
mod threads;
pub mod toon;
pub mod view;

#[cfg(feature = "cli")]
pub mod bench;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod data;
#[cfg(feature = "cli")]
mod interrupt;
#[cfg(feature = "cli")]
pub mod io;
#[cfg(feature = "cli")]
pub mod offline;
#[cfg(feature = "cli")]
pub mod program;
#[cfg(feature = "cli")]
pub mod simulate;
