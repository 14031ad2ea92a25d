//! Hand-drawn-looking effects on raw Vulkan: smoke, fire, and the motion blur of animated meshes, recorded into a host's
//! command buffer.
//!
//! A host makes an [`effect::Effect`] from a `Desc` and records a `Frame` of it: [`smoke`], [`flame`], [`blur`]. What it
//! must have is said in [`host`], what cameras and lights are in [`view`], what passes cost in [`profile`].
//!
//! # From a setting to a barrier
//!
//! 1. A setting is a line of a table: `sigma` in `smoke/settings.rs`. Range, default, the shot's key and the message
//!    follow from it ([`settings`]).
//! 2. `smoke/params.rs` tells it to the kernels, in a structure that build.rs makes of the block in `glsl/smoke/params.glsl`.
//! 3. A pass is declared in `smoke/passes.rs`: `rows` is `glsl/smoke/rows.comp`, under the name `smoke.rows`. What it binds
//!    follows from the names in the shader.
//! 4. `smoke/steps.rs` puts it into a frame's [`low_level::plan::Plan`], or says why it is left out: `sigma` is 0.
//! 5. `barrier.rs` derives which barriers the plan's steps need from what they read and write, and `gpu/recorder.rs` walks
//!    the plan into the command buffer.
//!
//! All effects are divided alike; [`effect`] has the table. The program `celfx` is a host of its own: `offline` drives
//! effects, and `program` has the line that makes one known to shots, layers, profiles and benchmarks.
#![deny(missing_docs, unsafe_op_in_unsafe_fn)]

// What hosts use.
pub mod blur;
pub mod effect;
pub mod error;
pub mod flame;
pub mod host;
pub mod low_level;
pub mod profile;
pub mod settings;
pub mod smoke;
pub mod toon;
pub mod tuning;
pub mod view;

// What effects are made of; `low_level` shows it.
mod barrier;
mod gpu;
mod layout;
mod noise;
mod plan;
mod random;
mod scan;
mod shaders;
mod threads;

// The program.
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
