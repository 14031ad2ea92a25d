//! Effects in all ways that their kernels are specialised for.

use ash::vk;

use crate::effect::{DeviceTraits, Effort, Kind, describe};
use crate::error::Result;
use crate::host::{DepthFormat, TemporalFormats};
use crate::plan::Pass;

/// The size of the pictures: what kernels are made of does not depend on it.
pub(super) const SIZE: [u32; 2] = [16, 16];
pub(super) const DEPTH: DepthFormat = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: false };
pub(super) const TEMPORAL: TemporalFormats =
    TemporalFormats { motion: Some(vk::Format::R16G16_SFLOAT), reactive: Some(vk::Format::R8_UNORM) };

/// Each of `N` switches on or off, in all ways.
pub(super) fn switches<const N: usize>() -> impl Iterator<Item = [bool; N]> {
    (0..1_u32 << N).map(|word| std::array::from_fn(|bit| word >> bit & 1 == 1))
}

/// The passes of an effect.
pub(super) fn passes<K: Kind>(desc: &K::Desc, traits: &DeviceTraits, effort: Effort) -> Result<Vec<Pass>> {
    Ok(describe(&mut K::new(desc, traits, effort)?, desc, effort).passes)
}
