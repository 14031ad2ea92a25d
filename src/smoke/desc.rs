//! Description of the effect.

use ash::vk;

use crate::error::{Error, Result};
use crate::host::{DepthFormat, TemporalFormats};
use crate::smoke::settings::{Pixels, Settings};

/// Lines that a whole picture can have.
const LINES: std::ops::RangeInclusive<u32> = 1..=1 << 16;

/// Description of a smoke effect. All of it is fixed until `Effect::change` or `resize`.
#[derive(Clone, Debug)]
pub struct Desc {
    /// Pixels of the picture, each at least 1.
    pub size: [u32; 2],
    /// Lines of the whole picture where this one is a part of it, as a tile is: what settings give in pixels at 1080 lines
    /// scales with them. None: those of `size`.
    pub lines: Option<u32>,
    /// Format of the target images; one that can be a colour attachment, blended, sampled and copied both ways.
    pub target_format: vk::Format,
    /// How the host's depth images hold depth, if they are to occlude the smoke.
    pub depth: Option<DepthFormat>,
    /// Whether frames may say what covers pixels in part; only with `depth`.
    pub edges: bool,
    /// The largest volume along each axis, in voxels.
    pub dimensions: [u32; 3],
    /// Whether volumes come with velocities.
    pub velocity: bool,
    /// Whether the light is a point light.
    pub point_light: bool,
    /// Whether lights may have a rim.
    pub rim: bool,
    /// Whether there may be a second light.
    pub second_light: bool,
    /// Whether frames may have a fire that lights the smoke.
    pub fire_light: bool,
    /// Same seed, same particles.
    pub seed: u32,
    /// The look.
    pub settings: Settings,
    /// Whether every buffer that is a layer is kept for reading after the frame.
    pub layers: bool,
    /// Outputs for temporal upscalers.
    pub temporal: TemporalFormats,
}

impl Desc {
    /// For pictures of `size` pixels and 32-bit floats and volumes of at most so many voxels without velocities, lit by a directional
    /// light; no depth, no layers,
    /// no outputs for temporal upscalers. What is to be otherwise is set after.
    pub fn new(size: [u32; 2], dimensions: [u32; 3], settings: Settings) -> Desc {
        Desc {
            size,
            lines: None,
            target_format: vk::Format::R32G32B32A32_SFLOAT,
            depth: None,
            edges: false,
            dimensions,
            velocity: false,
            point_light: false,
            rim: false,
            second_light: false,
            fire_light: false,
            seed: 0,
            settings,
            layers: false,
            temporal: TemporalFormats::default(),
        }
    }

    /// The settings' sizes in pixels of this picture.
    pub(super) fn pixels(&self) -> Pixels {
        self.settings.pixels(self.lines.unwrap_or(self.size[1]))
    }

    /// Checks every value that does not depend on the device.
    pub(super) fn validate(&self) -> Result<()> {
        self.settings.validate()?;
        self.temporal.validate()?;
        if self.size.contains(&0) {
            return Err(Error::setting("size", format!("{:?}", self.size), "at least 1 pixel a side"));
        }
        if self.lines.is_some_and(|lines| !LINES.contains(&lines)) {
            let allowed = format!("{} to {}", LINES.start(), LINES.end());
            return Err(Error::setting("lines", format!("{:?}", self.lines), allowed));
        }
        if self.dimensions.contains(&0) || self.dimensions.iter().any(|n| *n > 1 << 16) {
            let dimensions = format!("{:?}", self.dimensions);
            return Err(Error::setting("volume", dimensions, "1 to 65536 voxels a side"));
        }
        Ok(())
    }
}
