//! Description of the effect.

use ash::vk;

use crate::error::{Error, Result};
use crate::flame::settings::{HOTTEST, Pixels, Settings};
use crate::host::{DepthFormat, TemporalFormats};

/// Description of a flame effect. All of it is fixed until `Effect::change` or `resize`.
#[derive(Clone, Debug)]
pub struct Desc {
    /// Pixels of the picture, each at least 1.
    pub size: [u32; 2],
    /// Lines of the whole picture where this one is a part of it, as a tile is: what settings give in pixels at 1080 lines
    /// scales with them. None: those of `size`.
    pub lines: Option<u32>,
    /// Format of the target images; one that can be a colour attachment, blended, sampled and copied both ways.
    pub target_format: vk::Format,
    /// The scene in front of the fire and behind it, if frames say so.
    pub scene: Option<SceneFormat>,
    /// The most particles of a frame.
    pub particles: u32,
    /// The highest temperature of a frame in kelvin, above 0, at most [`HOTTEST`]: hotter particles count as this hot.
    pub hottest: f32,
    /// Same seed, same render particles.
    pub seed: u32,
    /// The look.
    pub settings: Settings,
    /// Whether frames may add their repetitions to those of the frame before ([`crate::flame::Frame::accumulate`]): the sums of all
    /// pixels are then kept between frames.
    pub accumulates: bool,
    /// Whether every buffer that is a layer is kept for reading after the frame.
    pub layers: bool,
    /// Outputs for temporal upscalers.
    pub temporal: TemporalFormats,
}

/// How frames hand over the depth of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneFormat {
    /// A depth image of the host.
    Image(DepthFormat),
    /// View depth in metres, `f32` a pixel, rows from the top, infinity where nothing is: as the smoke effect leaves it.
    Buffer,
}

impl Desc {
    /// For pictures of `size` pixels and 32-bit floats and at most so many particles, no hotter than the settings' hottest; no scene,
    /// no layers, nothing that is added up over frames, no outputs for temporal upscalers. What is to be otherwise is set after.
    pub fn new(size: [u32; 2], particles: u32, settings: Settings) -> Desc {
        Desc {
            size,
            lines: None,
            target_format: vk::Format::R32G32B32A32_SFLOAT,
            scene: None,
            particles,
            hottest: settings.hottest,
            seed: 0,
            settings,
            accumulates: false,
            layers: false,
            temporal: TemporalFormats::default(),
        }
    }

    /// The settings' sizes in pixels of this picture.
    pub(super) fn pixels(&self) -> Pixels {
        self.settings.pixels(self.lines.unwrap_or(self.size[1]))
    }

    /// Whether the mean depth of each pixel is kept: as a layer, or for motion vectors.
    pub(super) fn keeps_depth(&self) -> bool {
        self.layers || self.temporal.motion.is_some()
    }

    /// Checks every value that does not depend on the device.
    pub(super) fn validate(&self) -> Result<()> {
        self.settings.validate()?;
        self.temporal.validate()?;
        if self.size.contains(&0) {
            return Err(Error::setting("size", format!("{:?}", self.size), "at least 1 pixel a side"));
        }
        if !(self.hottest > 0.0 && self.hottest <= HOTTEST) {
            return Err(Error::setting("flame's hottest particle", self.hottest, "kelvin, above 0, at most 1e6"));
        }
        Ok(())
    }
}
