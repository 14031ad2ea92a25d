//! Fire from particles by stochastic alpha test (Mabuchi, Fujishiro, Ohno: Particle-Based Flame Rendering).

mod cie;
pub mod colour;
pub mod frame;
#[doc(hidden)]
pub mod reference;
pub mod settings;
mod spacing;

pub use crate::host::{Background, DepthFormat, HostDepth};
pub use frame::{Desc, Frame, ParticleInput, SceneDepth, SceneFormat};
pub use settings::Settings;
pub use spacing::mean_spacing;
