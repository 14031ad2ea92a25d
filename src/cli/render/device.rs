//! The device's side of `celfx render`: a shot's frames, in order.

use super::layers;
use super::outputs::Frame;
use crate::cli::{Common, Failure};
use crate::gpu::headless::{Headless, Messages, Options};
use crate::io::image::Picture;
use crate::io::shot::{Background, Shot};
use crate::io::volume::{Extent, Volume};
use crate::offline::{Offline, Scene, TARGET_FORMAT};
use crate::profile::FrameTimes;
use crate::smoke::{Desc, Sequence, Smoke};
use crate::view::LightSource;

/// Renders the frames of one shot, in order.
pub(super) struct Renderer<'a> {
    offline: Offline,
    messages: Messages,
    shot: &'a Shot,
    desc: Desc,
    timed: bool,
}

impl<'a> Renderer<'a> {
    /// Opens the device and makes everything that frames need. `timed`: passes are timed.
    pub(super) fn new(
        common: &Common,
        shot: &'a Shot,
        extent: Extent,
        layers: bool,
        timed: bool,
        background: Option<&Picture<[f32; 4]>>,
    ) -> Result<Renderer<'a>, Failure> {
        let options = Options { validate: common.validate, device: common.device.clone(), ..Options::default() };
        let headless = Headless::new(&options)?;
        let messages = headless.messages();
        let light = shot.light(shot.frames[0]).source;
        let desc = Desc {
            size: shot.size,
            target_format: TARGET_FORMAT,
            dimensions: extent.dimensions,
            velocity: extent.velocity,
            point_light: matches!(light, LightSource::Position(_)),
            seed: shot.seed,
            settings: shot.smoke.as_ref().map(|smoke| smoke.settings.clone()).unwrap_or_default(),
            layers,
            depth: None,
            skipping: true,
        };
        let mut offline = Offline::new(headless, desc.clone())?;
        if layers {
            offline.set_layers(&layers::BUFFERS)?;
        }
        match (&shot.background, background) {
            (_, Some(picture)) => offline.set_backdrop(&picture.pixels)?,
            (Background::Colour([r, g, b]), None) => offline.set_background([*r, *g, *b, 1.0]),
            _ => offline.set_background([0.0; 4]),
        }
        check(&messages)?;
        Ok(Renderer { offline, messages, shot, desc, timed })
    }

    /// The device and the memory that the effect takes, for people.
    pub(super) fn describe(&self) -> String {
        let memory = Smoke::memory(&self.desc, u64::MAX).unwrap_or_default();
        let mebibytes = memory.total().div_ceil(1 << 20);
        format!("device {}; {mebibytes} MiB of its memory", self.offline.device().info().to_string().trim())
    }

    /// Steps to frame `number`, with a volume if it is another than the frame before had, and renders it if asked for.
    /// Frames come in order, without gaps, from the shot's first.
    pub(super) fn step(
        &mut self,
        number: u32,
        volume: Option<&Volume>,
        rendered: bool,
    ) -> Result<(Option<Frame>, Option<FrameTimes>), Failure> {
        let Renderer { offline, shot, desc, .. } = self;
        offline.set_timed(self.timed && rendered);
        offline.frame(&Scene {
            sequence: if number == shot.frames[0] { Sequence::Restart } else { Sequence::Advance },
            dt: (1.0 / shot.fps) as f32,
            camera: shot.camera(number),
            light: shot.light(number),
            volume,
            rendered,
            number,
        })?;
        check(&self.messages)?;
        let frame = rendered.then(|| {
            let pixels = offline.picture().to_vec();
            let bytes = offline.layers().try_into();
            let layers = bytes.map(|bytes| layers::decode(bytes, pixels.len(), desc.settings.sigma > 0.0));
            // Without layers there are no bytes of them.
            Frame { number, pixels, layers: layers.unwrap_or_default() }
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
