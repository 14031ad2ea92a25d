//! Which of several ways a device takes to the same bits. Pure.

use ash::vk;

use crate::error::{Error, Result};

/// The ways that an effect takes where there are several with the same result: which is the fastest follows from the device.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize, serde::Serialize), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Tuning {
    /// Invocations that share the 256 pixels of a tile of the fire: 32, 64, 128 or 256. With 32 each holds a column of 8,
    /// which suits drivers that pack invocations into vectors; with 256 each holds one, and needs the fewest registers.
    pub tile_invocations: u32,
    /// Kernels of the fire's repetitions: 1 that looks up whether the mask is magnified or minified, or 2, one for each, of
    /// which one has an empty dispatch.
    pub mask_kernels: u32,
    /// Costs of the ways to search the radii of smoke's spheres.
    pub grow: GrowCosts,
}

/// Microseconds that a search for the radii of all particles takes beyond what all searches need, if the volume is new: only
/// their ratios matter. In a cube of `side` voxels a side:
///
/// - `growth`: `growth_base + growth_particle * particles`, for volumes at most 16 voxels wide
/// - `field`: `field_base + field_voxel * side^3 + field_particle * particles`
/// - `pyramid`: `pyramid_base + pyramid_level * levels + pyramid_side * side
///   + (pyramid_particle + pyramid_visit * side) * particles`
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize, serde::Serialize), serde(deny_unknown_fields))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the formulas say what each is")]
pub struct GrowCosts {
    pub growth_base: f64,
    pub growth_particle: f64,
    pub field_base: f64,
    pub field_voxel: f64,
    pub field_particle: f64,
    pub pyramid_base: f64,
    pub pyramid_level: f64,
    pub pyramid_side: f64,
    pub pyramid_particle: f64,
    pub pyramid_visit: f64,
}

impl GrowCosts {
    /// Fitted to two cores under lavapipe (`celfx bench smoke --only grow`, a plume in a cube of `side` voxels). Milliseconds:
    ///
    /// | side, particles | growth | field | pyramid |
    /// |---|---|---|---|
    /// | 16, 500 | 0.24 | 0.36 | 0.37 |
    /// | 16, 10,000 | 1.5 | 1.1 | 2.5 |
    /// | 48, 500 | 0.65 | 1.06 | 0.94 |
    /// | 48, 2,000 | 1.5 | 1.16 | 1.48 |
    /// | 64, 2,000 | | 2.2 | 2.0 |
    /// | 64, 10,000 | | 2.8 | 7.2 |
    /// | 128, 2,000 | | 14.6 | 6.0 |
    /// | 128, 10,000 | | 15.4 | 14.9 |
    /// | 128, 50,000 | | 18.5 | 58 |
    /// | 256, 10,000 | | 120 | 47 |
    /// | 256, 50,000 | | 122 | 127 |
    pub const CPU: GrowCosts = GrowCosts {
        growth_base: 0.0,
        growth_particle: 0.2,
        field_base: 200.0,
        field_voxel: 5.2e-3,
        field_particle: 0.08,
        pyramid_base: 100.0,
        pyramid_level: 0.0,
        pyramid_side: 0.0,
        pyramid_particle: 0.16,
        pyramid_visit: 7.2e-3,
    };

    /// Counted, not measured, until somebody has (`celfx bench calibrate`): [`GrowCosts::STEP`] for each step that waits for
    /// another, [`GrowCosts::READ`] for each read of a chain in which one says where the next is, and
    /// [`GrowCosts::BYTE`] for each byte. A field is three passes that read and write a byte a voxel; a walk of the pyramid
    /// reads about 22 words and one more for each voxel of the side, as the paper's loop reads 28 in small volumes.
    pub const GPU: GrowCosts = GrowCosts {
        growth_base: Self::STEP + 28.0 * Self::READ,
        growth_particle: 28.0 * 8.0 * Self::BYTE,
        field_base: 4.0 * Self::STEP,
        field_voxel: 6.1 * Self::BYTE,
        field_particle: 32.0 * Self::BYTE,
        pyramid_base: Self::STEP + 22.0 * Self::READ,
        pyramid_level: Self::STEP,
        pyramid_side: Self::READ,
        pyramid_particle: 22.0 * 8.0 * Self::BYTE,
        pyramid_visit: 8.0 * Self::BYTE,
    };
    /// Microseconds in which a GPU empties itself and begins anew.
    pub const STEP: f64 = 4.0;
    /// Microseconds of a read from memory.
    pub const READ: f64 = 0.5;
    /// Microseconds of a byte at 1 TB/s.
    pub const BYTE: f64 = 1e-6;

    pub(crate) fn terms(&self) -> [f64; 10] {
        let GrowCosts { growth_base, growth_particle, field_base, field_voxel, field_particle, .. } = *self;
        let GrowCosts { pyramid_base, pyramid_level, pyramid_side, pyramid_particle, pyramid_visit, .. } = *self;
        [
            growth_base,
            growth_particle,
            field_base,
            field_voxel,
            field_particle,
            pyramid_base,
            pyramid_level,
            pyramid_side,
            pyramid_particle,
            pyramid_visit,
        ]
    }

    pub(crate) fn growth(&self, particles: f64) -> f64 {
        self.growth_base + self.growth_particle * particles
    }

    pub(crate) fn field(&self, particles: f64, voxels: f64) -> f64 {
        self.field_base + self.field_voxel * voxels + self.field_particle * particles
    }

    pub(crate) fn pyramid(&self, particles: f64, voxels: f64, levels: u32) -> f64 {
        let side = voxels.cbrt();
        let walks = (self.pyramid_particle + self.pyramid_visit * side) * particles;
        self.pyramid_base + self.pyramid_level * f64::from(levels) + self.pyramid_side * side + walks
    }
}

impl Tuning {
    /// Of drivers that run shaders on the CPU.
    pub const CPU: Tuning = Tuning { tile_invocations: 32, mask_kernels: 2, grow: GrowCosts::CPU };
    /// Of GPUs.
    pub const GPU: Tuning = Tuning { tile_invocations: 256, mask_kernels: 1, grow: GrowCosts::GPU };

    /// Of a device of this type.
    pub fn of(device: vk::PhysicalDeviceType) -> Tuning {
        if device == vk::PhysicalDeviceType::CPU { Tuning::CPU } else { Tuning::GPU }
    }

    /// Refuses values that kernels are not made for.
    ///
    /// # Errors
    /// Names the first of them, and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let refuse = |name, value, allowed: &str| Err(Error::setting(name, value, allowed));
        if let Some(cost) = self.grow.terms().into_iter().find(|cost| !(0.0..1e12).contains(cost)) {
            return Err(Error::setting("tuning.grow", cost, "microseconds, 0 to 1e12"));
        }
        match *self {
            Tuning { tile_invocations, .. } if ![32, 64, 128, 256].contains(&tile_invocations) => {
                refuse("tuning.tile_invocations", tile_invocations, "32, 64, 128 or 256")
            }
            Tuning { mask_kernels, .. } if ![1, 2].contains(&mask_kernels) => {
                refuse("tuning.mask_kernels", mask_kernels, "1 or 2")
            }
            _ => Ok(()),
        }
    }
}
