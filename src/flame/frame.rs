//! A host's description of one frame.

use crate::error::{Error, Result};
use crate::flame::desc::{Desc, SceneFormat};
use crate::host::{Background, HostBuffer, HostImage, TemporalImages, check_buffer, check_depth, check_target};
use crate::view::View;

/// The depth of the scene: what is nearer hides fire.
#[derive(Clone, Copy, Debug)]
pub enum SceneDepth {
    /// A depth image of the target's size, drawn through the frame's view. Usage: `TRANSFER_SRC`.
    Image(HostImage),
    /// View depth in metres a pixel ([`SceneFormat::Buffer`]). Usage: `TRANSFER_SRC`.
    Buffer(HostBuffer),
}

/// Particles on the device.
#[derive(Clone, Copy, Debug)]
pub struct ParticleInput {
    /// How many; at most what the effect was made for.
    pub count: u32,
    /// The highest temperature among them in kelvin, or any bound above it: lets a frame be skipped in which none can be
    /// seen. Infinity if nothing is known.
    pub hottest: f32,
    /// Four `f32` a particle: position in metres (x, y, z), temperature in kelvin. A particle that is not finite, or
    /// beyond [`crate::view::FARTHEST`], or not above 0 K, is left out. Usage: `TRANSFER_SRC`.
    pub position_temperature: HostBuffer,
    /// A `u32` a particle that keeps its random draws over frames; none: its row. Usage: `TRANSFER_SRC`.
    pub ids: Option<HostBuffer>,
    /// Four `f32` a particle: where it was in the frame before, in metres (x, y, z), and one that is not used. One that is not finite has
    /// not moved; none: no particle has. Only if the effect was made for motion vectors. Usage: `TRANSFER_SRC`.
    pub previous: Option<HostBuffer>,
    /// Four `f32` a particle: its velocity in m/s (x, y, z), and one that is not used. One that is not finite counts as still; none: all
    /// are. Not read unless `Settings::stretch` is above 0. Usage: `TRANSFER_SRC`.
    pub velocity: Option<HostBuffer>,
}

/// One frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// What it is seen through.
    pub view: View,
    /// This frame's particles; none if they are those of the last one recorded. The first frame needs some (their number
    /// may be 0).
    pub particles: Option<ParticleInput>,
    /// How far sprites are from their particle at most in this frame, in metres, 0 to 1e6: what
    /// [`crate::flame::mean_spacing`] finds, smoothed in time. Instead of the settings' `spread`; sprites are as large where the
    /// settings have no `size`. None: the settings' spread, or without one that of the last frame recorded. Nothing is made
    /// anew for it but, in the mode "expected" with a `size`, a table.
    pub spread: Option<f32>,
    /// Number of the frame: with `flicker`, what draws are taken from.
    pub number: u32,
    /// Adds this frame's repetitions to those of the frame before, of which nothing else may have changed: particles,
    /// view, scene. Not with `adaptive`.
    pub accumulate: bool,
    /// Where it goes. Usage: `COLOR_ATTACHMENT`, and `TRANSFER_DST` for a background that is an image.
    pub target: HostImage,
    /// The background.
    pub background: Background,
    /// The depth of the scene, given exactly if the effect was made for one.
    pub scene: Option<SceneDepth>,
    /// Outputs for temporal upscalers. What a pixel shows is at its mean depth, and has moved as the particles whose sprites reach the
    /// pixel have in the mean: weighed by their render particles and by how near they are to that place.
    pub temporal: TemporalImages,
}

impl SceneDepth {
    /// Its image, if it is one.
    pub(super) fn image(self) -> Option<HostImage> {
        match self {
            SceneDepth::Image(image) => Some(image),
            SceneDepth::Buffer(_) => None,
        }
    }
}

impl ParticleInput {
    /// So many particles, of which nothing else is known. What is to be otherwise is set after.
    pub fn new(count: u32, position_temperature: HostBuffer) -> ParticleInput {
        ParticleInput { count, hottest: f32::INFINITY, position_temperature, previous: None, velocity: None, ids: None }
    }

    fn validate(&self, desc: &Desc) -> Result<()> {
        let refuse = |why: String| Err(Error::HostResource { name: "particles", why });
        let ParticleInput { count, hottest, position_temperature, ids, previous, velocity } = *self;
        if count > desc.particles {
            return refuse(format!("{count} of them; the effect was made for at most {}", desc.particles));
        }
        if hottest.is_nan() {
            return refuse("their highest temperature is NaN; expected a bound in kelvin, or infinity".to_owned());
        }
        let bytes = u64::from(count);
        if position_temperature.size < 16 * bytes || ids.is_some_and(|ids| ids.size < 4 * bytes) {
            return refuse(format!("their buffers are smaller than {count} particles need"));
        }
        if let Some(velocity) = velocity {
            check_buffer("particles", &velocity, 16 * bytes)?;
        }
        match previous {
            Some(_) if desc.temporal.motion.is_none() => {
                let why = "ParticleInput::previous is given; the effect was made without Desc::temporal.motion";
                return refuse(why.to_owned());
            }
            Some(previous) => check_buffer("particles", &previous, 16 * bytes)?,
            None => {}
        }
        Ok(())
    }
}

impl Frame {
    /// Frame 0, over what the target holds, without a scene. What is to be otherwise is set after.
    pub fn new(view: View, particles: ParticleInput, target: HostImage) -> Frame {
        Frame {
            view,
            particles: Some(particles),
            spread: None,
            number: 0,
            accumulate: false,
            target,
            background: Background::Keep,
            scene: None,
            temporal: TemporalImages::default(),
        }
    }

    pub(crate) fn validate(&self, desc: &Desc, first: bool) -> Result<()> {
        self.view.validate()?;
        match &self.particles {
            Some(particles) => particles.validate(desc)?,
            None if first => {
                let why = "the first frame needs some".to_owned();
                return Err(Error::HostResource { name: "particles", why });
            }
            None => {}
        }
        if let Some(spread) = self.spread.filter(|spread| !(0.0..=1e6).contains(spread)) {
            return Err(Error::setting("frame.spread", spread, "metres, 0 to 1e6"));
        }
        if self.accumulate && !desc.accumulates {
            return Err(Error::setting(
                "frame.accumulate",
                true,
                "not unless the effect is made for it: Desc::accumulates",
            ));
        }
        if self.accumulate && desc.settings.is_adaptive() {
            return Err(Error::setting("frame.accumulate", true, "not with flame.adaptive"));
        }
        check_target(&self.target, &self.background, desc.size, desc.target_format)?;
        let (background, scene) = (self.background.image(), self.scene.and_then(SceneDepth::image));
        let others = [background.as_ref(), scene.as_ref()];
        self.temporal.check(&desc.temporal, desc.size, &self.target, &others)?;
        match (&self.scene, desc.scene) {
            (None, None) => Ok(()),
            (Some(SceneDepth::Image(depth)), Some(SceneFormat::Image(made))) => {
                check_depth("scene", Some((depth, &self.view)), desc.size, Some(made))
            }
            (Some(SceneDepth::Buffer(buffer)), Some(SceneFormat::Buffer)) => {
                check_buffer("scene", buffer, 4 * u64::from(desc.size[0]) * u64::from(desc.size[1]))
            }
            (given, made) => {
                let given = given.map(|given| match given {
                    SceneDepth::Image(_) => "an image",
                    SceneDepth::Buffer(_) => "a buffer",
                });
                let why = format!("{}; the effect was made for {made:?}", given.unwrap_or("none"));
                Err(Error::HostResource { name: "scene", why })
            }
        }
    }
}
