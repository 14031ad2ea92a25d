//! What temporal upscalers take besides a picture: motion vectors and a reactive mask.

use ash::vk;

use super::check::{Content, NamedFormat, check_image, is_same, mismatch, refuse};
use super::{FormatUse, HostImage};
use crate::error::{Error, Result};
use crate::view::View;

/// Which outputs for temporal upscalers an effect is made for, and the formats of the host's images of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TemporalFormats {
    /// Of the motion vectors, if there are any: one of [`MOTION_FORMATS`].
    pub motion: Option<vk::Format>,
    /// Of the reactive mask, if there is one: one of [`REACTIVE_FORMATS`].
    pub reactive: Option<vk::Format>,
}

/// What a frame's outputs for temporal upscalers go to: images are given exactly if the effect was made for them, and where the picture's
/// target is. Both have the target's offset, and are neither its image nor another one of the frame. What they hold is kept where the effect
/// shows nothing, so that effects and the host share them. Usage: `COLOR_ATTACHMENT`.
#[derive(Clone, Copy, Debug, Default)]
pub struct TemporalImages {
    /// Pixels to the right and down (red, green; 0 in others) from where what a pixel shows is seen in this frame to where it was seen in
    /// the frame before, both without jitter; at most 65504 along each axis. 0 in a first frame. Written where at least half of the pixel is
    /// the effect's: [`Self::reactive`] has the rest, too.
    pub motion: Option<HostImage>,
    /// The share of a pixel that the effect covers, 0 to 1, or what the image holds if that is larger.
    pub reactive: Option<HostImage>,
    /// What the frame before was seen through in this picture: needed where an effect has several, as two eyes. None: what the frame
    /// recorded before was seen through. Only with motion vectors. A blur has it in its interval, of which it must then be frame i's.
    pub previous: Option<View>,
}

/// Formats that motion vectors can have.
pub const MOTION_FORMATS: [vk::Format; 4] = [
    vk::Format::R16G16_SFLOAT,
    vk::Format::R32G32_SFLOAT,
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R32G32B32A32_SFLOAT,
];

/// Formats that a reactive mask can have.
pub const REACTIVE_FORMATS: [vk::Format; 3] = [vk::Format::R8_UNORM, vk::Format::R16_SFLOAT, vk::Format::R32_SFLOAT];

const MOTION: &str = "temporal.motion";
const REACTIVE: &str = "temporal.reactive";
const PREVIOUS: &str = "temporal.previous";

impl TemporalFormats {
    /// Refuses formats that the outputs cannot have.
    pub(crate) fn validate(&self) -> Result<()> {
        check_one_of(MOTION, self.motion, &MOTION_FORMATS)?;
        check_one_of(REACTIVE, self.reactive, &REACTIVE_FORMATS)
    }

    /// What the device must be able to use them as.
    pub(crate) fn formats(&self) -> impl Iterator<Item = NamedFormat> {
        use vk::FormatFeatureFlags as Use;
        let drawn = |features| move |format| FormatUse { format, features };
        let motion = self.motion.map(drawn(Use::COLOR_ATTACHMENT));
        let reactive = self.reactive.map(drawn(Use::COLOR_ATTACHMENT | Use::COLOR_ATTACHMENT_BLEND));
        motion.map(|format| (MOTION, format)).into_iter().chain(reactive.map(|format| (REACTIVE, format)))
    }
}

impl TemporalImages {
    /// Refuses images that do not fit an effect made for `made`, or that are among `others`, the frame's other images.
    pub(crate) fn check(
        &self,
        made: &TemporalFormats,
        size: [u32; 2],
        target: &HostImage,
        others: &[Option<&HostImage>],
    ) -> Result<()> {
        let pairs = [(MOTION, &self.motion, made.motion), (REACTIVE, &self.reactive, made.reactive)];
        for (name, given, format) in pairs {
            let (image, format) = match (given, format) {
                (None, None) => continue,
                (Some(image), Some(format)) => (image, format),
                (given, made) => return refuse(name, mismatch(name, given.is_some(), made)),
            };
            check_image(name, image, size, format, Content::Kept)?;
            if image.offset != target.offset {
                let (found, expected) = (image.offset, target.offset);
                return refuse(name, format!("offset {found:?}; expected {expected:?}, as the target's"));
            }
            let is_taken = |other: &&HostImage| is_same(image, other);
            if others.iter().flatten().chain([&target]).any(is_taken) {
                return refuse(name, "it is the target's image, or another one of the frame".to_owned());
            }
        }
        match (&self.motion, &self.reactive) {
            (Some(motion), Some(reactive)) if is_same(motion, reactive) => {
                refuse(REACTIVE, "it is the image of the motion vectors".to_owned())
            }
            _ => self.check_previous(made),
        }
    }

    fn check_previous(&self, made: &TemporalFormats) -> Result<()> {
        let Some(previous) = &self.previous else { return Ok(()) };
        if made.motion.is_none() {
            return refuse(PREVIOUS, mismatch::<()>(MOTION, true, None));
        }
        previous.validate().map_err(|error| match error {
            Error::Setting { name, value, allowed } => {
                Error::Setting { name: name.replacen("view", PREVIOUS, 1).into(), value, allowed }
            }
            other => other,
        })
    }

    /// Refuses all of it: there is no picture.
    pub(crate) fn check_none(&self) -> Result<()> {
        let given = [(MOTION, self.motion.is_some()), (REACTIVE, self.reactive.is_some())];
        match given.into_iter().chain([(PREVIOUS, self.previous.is_some())]).find(|(_, is_given)| *is_given) {
            Some((name, _)) => refuse(name, "given; a frame without a target has no outputs".to_owned()),
            None => Ok(()),
        }
    }

    /// Refuses another view of the frame before than `view`, if one is said, but for jitter.
    pub(crate) fn check_is_previous(&self, view: &View) -> Result<()> {
        match &self.previous {
            Some(previous) if previous.without_jitter() != view.without_jitter() => {
                refuse(PREVIOUS, "another view than the interval's of frame i".to_owned())
            }
            _ => Ok(()),
        }
    }
}

fn check_one_of(name: &'static str, format: Option<vk::Format>, allowed: &[vk::Format]) -> Result<()> {
    match format {
        Some(format) if !allowed.contains(&format) => refuse(name, format!("{format:?}; expected one of {allowed:?}")),
        _ => Ok(()),
    }
}
