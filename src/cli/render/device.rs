//! The device's side of `celfx render`: a shot's frames, in order.

use super::input::Step;
use super::layers;
use super::outputs::Frame;
use crate::blur::params::{Control, ENDED_BY_BUDGET, ROUNDS};
use crate::blur::{self, Blur};
use crate::cli::{Common, Failure, interrupt};
use crate::gpu::headless::{Headless, Messages, Options};
use crate::io::image::Picture;
use crate::io::shot::{Background, Shot};
use crate::offline::{BlurScene, EffectBuffer, Effects, Offline, Scene};
use crate::profile::FrameTimes;
use crate::smoke::Sequence;

/// What the device has decided of a blurred frame.
const CONTROL: EffectBuffer = EffectBuffer::Blur(blur::layout::CONTROL);

/// Renders the frames of one shot, in order.
pub(super) struct Renderer<'a> {
    offline: Offline,
    messages: Messages,
    shot: &'a Shot,
    effects: Effects,
    /// Particles of the frame rendered last.
    particles: usize,
    timed: bool,
    /// What is to be said of the frame rendered last.
    warning: Option<String>,
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
        let (validate, device) = (common.validate, common.device.clone());
        let options = Options { validate, device, go_on: interrupt::go_on, ..Options::default() };
        let headless = Headless::new(&options)?;
        let messages = headless.messages();
        let mut offline = Offline::new(headless, effects.clone())?;
        let mut buffers = if layers { layers::buffers(&effects) } else { Vec::new() };
        // The last one tells how the refinement ended.
        buffers.extend(effects.blur.iter().map(|_| CONTROL));
        offline.set_layers(&buffers)?;
        match (&shot.background, background) {
            (_, Some(picture)) => offline.set_backdrop(&picture.pixels)?,
            (Background::Colour([r, g, b]), None) => offline.set_background([*r, *g, *b, 1.0]),
            _ => offline.set_background([0.0; 4]),
        }
        check(&messages)?;
        Ok(Renderer { offline, messages, shot, effects, particles: 0, timed, warning: None })
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
        let Renderer { offline, shot, effects, particles, warning, .. } = self;
        let Step { number, origin, rendered, .. } = *step;
        offline.set_timed(self.timed && rendered);
        offline.frame(&Scene {
            sequence: if number == shot.frames[0] { Sequence::Restart } else { Sequence::Advance },
            dt: (1.0 / shot.fps) as f32,
            camera: shot.camera(number),
            light: shot.light(number),
            volume: step.volume.as_deref(),
            particles: step.particles.as_deref(),
            depth: None,
            blur: step.blur.as_ref().map(|blur| BlurScene {
                frame: &blur.frame,
                images: [0, 1].map(|i| blur.images[i].as_deref().map(|picture| &picture.pixels[..])),
                outer: [0, 1].map(|i| blur.outer[i].as_deref().map(|picture| &picture.pixels[..])),
            }),
            accumulate: false,
            rendered,
            number,
        })?;
        check(&self.messages)?;
        *particles = step.particles.as_ref().map_or(*particles, |particles| particles.position.len());
        let is_still = offline.blur().is_some_and(|blur| is_still(blur));
        *warning = step.blur.as_ref().and_then(|_| ended(offline, effects, number));
        let frame = rendered.then(|| {
            let is_alone = effects.smoke.is_none() && effects.flame.is_none();
            let picture = offline.picture();
            let motion = step.blur.as_ref().map(|blur| &blur.frame);
            let blurred = motion.map(|motion| layers::Blurred { motion, picture, is_alone, is_still });
            let layers = layers::decode(effects, &offline.layers(), *particles, shot.size, blurred);
            Frame { number, origin, pixels: offline.picture().to_vec(), layers }
        });
        Ok((frame, offline.times()))
    }

    /// Whether the device can time passes.
    pub(super) fn has_clock(&self) -> bool {
        self.offline.has_clock()
    }

    /// What is to be said of the frame rendered last.
    pub(super) fn warning(&mut self) -> Option<String> {
        self.warning.take()
    }

    /// Destroys everything; what validation says about that is an error too.
    pub(super) fn finish(self) -> Result<(), Failure> {
        drop(self.offline);
        check(&self.messages)
    }
}

/// Whether nothing moved in the frame recorded last.
fn is_still(blur: &Blur) -> bool {
    blur.skipped().any(|(pass, _)| pass == "blur.refine")
}

/// Says it where a frame's refinement did not come to its own end.
fn ended(offline: &mut Offline, effects: &Effects, number: u32) -> Option<String> {
    let desc = effects.blur.as_ref()?;
    if is_still(offline.blur()?) {
        return None;
    }
    let layers = offline.layers();
    let control: Control = layers.last()?.get(..size_of::<Control>()).map(bytemuck::pod_read_unaligned)?;
    let Control { triangles, undivided, .. } = control;
    let (key, value) = match desc.settings.refine {
        blur::settings::Refine::Error => ("blur.tolerance", desc.settings.tolerance),
        blur::settings::Refine::Length => ("blur.edge", desc.settings.edge),
    };
    let why = match control.ended_by {
        0 => return None,
        ENDED_BY_BUDGET => "there is room for no more".to_owned(),
        _ => format!("{ROUNDS} rounds are the most"),
    };
    Some(format!(
        "frame {number}: the blur's refinement ended at {triangles} triangles, {undivided} of which are coarser than \
         {key} = {value} asks for: {why}. Raise {key}, or use a simpler mesh"
    ))
}

/// A message of validation is an error.
fn check(messages: &Messages) -> Result<(), Failure> {
    let messages = messages.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    match messages.first() {
        Some(first) => Err(Failure::new(Failure::DEVICE, format!("validation: {first}"))),
        None => Ok(()),
    }
}
