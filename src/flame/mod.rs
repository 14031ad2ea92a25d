//! Fire from particles by stochastic alpha test (Mabuchi, Fujishiro, Ohno: Particle-Based Flame Rendering).

pub mod frame;
pub mod settings;

pub use crate::host::{Background, DepthFormat, HostDepth};
pub use frame::{Desc, Frame, ParticleInput, SceneDepth, SceneFormat};
pub use settings::Settings;
