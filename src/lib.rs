//! Hand-drawn-looking effects on raw Vulkan: smoke, fire, and the motion blur of animated meshes, recorded into a host's
//! command buffer.
//!
//! A host makes an [`effect::Effect`] from a `Desc` and records a `Frame` of it: [`smoke`], [`flame`], [`blur`]. What it
//! must have is said in [`host`], what views, cameras and lights are in [`view`], what passes cost in [`profile`].
//!
//! # A host's guide
//!
//! ```no_run
//! use celfx::ash::vk;
//! use celfx::effect::Kernels;
//! use celfx::error::Result;
//! use celfx::gpu_allocator::vulkan::Allocator;
//! use celfx::host::Host;
//! use celfx::profile::Timing;
//! use celfx::smoke::{Desc, Frame, Smoke};
//!
//! /// # Safety
//! /// All handles are of one device that has what `celfx::host::requirements` names enabled.
//! unsafe fn a_frame(
//!     host: &Host, kernels: &Kernels, allocator: &mut Allocator, desc: Desc, frame: &Frame, commands: vk::CommandBuffer,
//! ) -> Result<Smoke> {
//!     unsafe {
//!         let mut smoke = Smoke::new(host, kernels, allocator, desc)?;
//!         smoke.record(host, commands, frame, &mut Timing::None)?;
//!         Ok(smoke)
//!     }
//! }
//! ```
//!
//! - **Create.** [`effect::Kernels`] holds the pipelines of a device; make one and keep it. `Effect::compile` makes the
//!   pipelines of a `Desc` on any thread. `Effect::new` then makes none; it takes buffers and images, as many bytes as
//!   `Effect::memory` says.
//! - **Record.** `Effect::record` checks the frame and records it. It submits nothing, waits for nothing, and allocates nothing.
//!   Or `prepare` the frame and `record_steps` of it, with your own commands between. Images and buffers are in the states that
//!   the frame declares ([`host::ImageState`], [`host::HostBuffer`]), and images are left in the state that it asks for.
//! - **Share memory.** What an effect rewrites in each frame is scratch: effects whose frames are recorded one after the other can have
//!   it in one [`effect::ScratchPool`] (`Effect::scratch_needs`, `Effect::new_in`).
//! - **Change and resize.** `Effect::change` takes another `Desc` between any two frames, `resize` another size, `change_in` another pool, too. What is replaced is
//!   handed back ([`effect::Retired`]); nothing waits.
//! - **Two views** of a frame, as for two eyes: record it twice. The second time smoke has `Sequence::Again`, and a blur an interval
//!   found in the second view, without the mesh and poses, which are there. With motion vectors say what each view was before
//!   (`TemporalImages::previous`). A fire that accumulates (`flame::Frame::accumulate`) needs an effect a view.
//! - **Temporal upscalers** get motion vectors and a reactive mask of each effect, if its `Desc` asks for them ([`host::TemporalFormats`]).
//! - **Destroy.** `Effect::retire`, and [`effect::Retired::destroy`] when the GPU is done with all recorded frames; then
//!   `Kernels::destroy`. Only what celfx has made is destroyed.
//! - **Time.** [`profile::Timing`] takes a [`profile::Profiler`] or your own queries, two a step.
//! - **Errors.** [`error::Error`] names the setting, image, buffer or Vulkan call, and what is allowed. A refused frame has recorded
//!   nothing and changed nothing. A frame that was recorded and never submitted: `Effect::frame_dropped`.
//! - **Threads.** All types are `Send`; what takes `&self` is `Sync`. Several threads may make effects with one `Kernels`. An effect is
//!   recorded by one thread at a time, and its frames are submitted in order to one queue.
//! - **Targets** hold linear light with premultiplied alpha. UNORM targets hold it as numbers from 0 to 1, sRGB formats encode it;
//!   float targets hold what is brighter, too.
//!
//! A frame's images and buffers, and what each must be usable as:
//!
//! | resource | usage | before | after |
//! |---|---|---|---|
//! | target | `COLOR_ATTACHMENT`; for a background, and for [`blur`], `TRANSFER_DST` | `state_in`; `UNDEFINED` if a background covers it | `state_out` |
//! | [`host::Background::Copy`] | `TRANSFER_SRC` | `state_in` | `state_out` |
//! | depth of [`smoke`] and [`blur`]: tested and written | `DEPTH_STENCIL_ATTACHMENT` | `state_in` | `state_out` |
//! | depth of [`flame`]: read | `TRANSFER_SRC` | `state_in` | `state_out` |
//! | images of a [`blur`]'s frames: read | `TRANSFER_SRC` | `state_in` | `state_out` |
//! | motion vectors, reactive mask ([`host::TemporalImages`]): drawn into where the effect is seen | `COLOR_ATTACHMENT` | `state_in` | `state_out` |
//! | positions that a [`blur`]'s host has skinned | `STORAGE_BUFFER` | `stage` and `access` of the last write | read at `COMPUTE_SHADER` |
//! | all other buffers | `TRANSFER_SRC` | `stage` and `access` of the last write | read at `ALL_TRANSFER` |
//!
//! The first frame of each: [`smoke::Frame`] has `Sequence::Restart` and a volume; [`flame::Frame`] has particles; [`blur::Frame`]
//! has the mesh, and poses as its interval needs them. A blur's first output has no frame before it, so nothing moves in it: its
//! interval is `None`, and it shows frame i + 1 as it is.
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

// Their types are in celfx's interface.
pub use {ash, glam, gpu_allocator};

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
mod srgb;
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
