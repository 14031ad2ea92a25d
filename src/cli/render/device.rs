//! The device's side of `celfx render`: a shot's frames, in order.

use super::input::Step;
use super::layers;
use super::outputs::Frame;
use crate::cli::{Common, Failure};
use crate::gpu::headless::{Headless, Messages, Options};
use crate::io::image::Picture;
use crate::io::shot::{Background, Shot};
use crate::offline::{Effects, Offline, Scene};
use crate::profile::FrameTimes;
use crate::smoke::Sequence;

/// Renders the frames of one shot, in order.
pub(super) struct Renderer<'a> {
    offline: Offline,
    messages: Messages,
    shot: &'a Shot,
    effects: Effects,
    /// Particles of the frame rendered last.
    particles: usize,
    timed: bool,
}

impl<'a> Renderer<'a> {
    /// Opens the device and makes everything that frames need. `layers`: they are read back; `timed`: passes are timed.
    pub(super) fn new(
        common: &Common,
        shot: &'a Shot,
        effects: Effects,
        layers: bool,
        timed: bool,
        background: Option<&Picture<[f32; 4]>>,
    ) -> Result<Renderer<'a>, Failure> {
        let options = Options { validate: common.validate, device: common.device.clone(), ..Options::default() };
        let headless = Headless::new(&options)?;
        let messages = headless.messages();
        let mut offline = Offline::new(headless, effects.clone())?;
        if layers {
            offline.set_layers(&layers::buffers(&effects))?;
        }
        match (&shot.background, background) {
            (_, Some(picture)) => offline.set_backdrop(&picture.pixels)?,
            (Background::Colour([r, g, b]), None) => offline.set_background([*r, *g, *b, 1.0]),
            _ => offline.set_background([0.0; 4]),
        }
        check(&messages)?;
        Ok(Renderer { offline, messages, shot, effects, particles: 0, timed })
    }

    /// The device, the memory that the effects take, and what the shot left to its input, for people.
    pub(super) fn describe(&self) -> String {
        let device = self.offline.device().info().to_string();
        let mebibytes = self.offline.memory().div_ceil(1 << 20);
        let is_given = self.shot.flame.as_ref().is_some_and(|flame| flame.settings.spread.is_some());
        let spread = match self.effects.flame.as_ref().and_then(|desc| desc.settings.spread) {
            Some(spread) if !is_given => format!("; flame.spread = {spread} m"),
            _ => String::new(),
        };
        format!("device {}; {mebibytes} MiB of its memory{spread}", device.trim())
    }

    /// Takes a step, and renders it if that is asked for. With smoke, steps come without gaps from the shot's first frame.
    pub(super) fn step(&mut self, step: &Step) -> Result<(Option<Frame>, Option<FrameTimes>), Failure> {
        let Renderer { offline, shot, effects, particles, .. } = self;
        let Step { number, rendered, .. } = *step;
        offline.set_timed(self.timed && rendered);
        offline.frame(&Scene {
            sequence: if number == shot.frames[0] { Sequence::Restart } else { Sequence::Advance },
            dt: (1.0 / shot.fps) as f32,
            camera: shot.camera(number),
            light: shot.light(number),
            volume: step.volume.as_deref(),
            particles: step.particles.as_deref(),
            depth: None,
            accumulate: false,
            rendered,
            number,
        })?;
        check(&self.messages)?;
        *particles = step.particles.as_ref().map_or(*particles, |particles| particles.position.len());
        let frame = rendered.then(|| {
            let layers = layers::decode(effects, &offline.layers(), *particles);
            Frame { number, pixels: offline.picture().to_vec(), layers }
        });
        Ok((frame, offline.times()))
    }

    /// Destroys everything; what validation says about that is an error too.
    pub(super) fn finish(self) -> Result<(), Failure> {
        drop(self.offline);
        check(&self.messages)
    }
}

/// A message of validation is an error.
fn check(messages: &Messages) -> Result<(), Failure> {
    let messages = messages.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    match messages.first() {
        Some(first) => Err(Failure::new(Failure::DEVICE, format!("validation: {first}"))),
        None => Ok(()),
    }
}
