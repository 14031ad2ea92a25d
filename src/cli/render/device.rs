//! The device's side of `celfx render`: a shot's frames, in order.

use super::outputs::Frame;
use super::reader::Step;
use crate::cli::{Common, Failure};
use crate::gpu::headless::{Headless, Messages};
use crate::io::image::Picture;
use crate::io::shot::{Background, Shot};
use crate::offline::{EffectBuffer, Effects, Offline};
use crate::profile::FrameTimes;
use crate::program::layers::{self, Layer, LayerData, Rendered, Wanted};
use crate::program::{self, EFFECTS};

/// Renders the frames of one shot, in order.
pub(super) struct Renderer<'a> {
    offline: Offline,
    messages: Messages,
    shot: &'a Shot,
    effects: Effects,
    /// Buffers read back with each frame.
    buffers: Vec<EffectBuffer>,
    /// Layers that are made.
    wanted: Wanted,
    timed: bool,
    /// Remarks on the frame rendered last.
    remarks: Vec<String>,
}

impl<'a> Renderer<'a> {
    /// Opens the device and makes everything that frames need. `wanted`: layers that are read back; `timed`: passes are timed.
    pub(super) fn new(
        common: &Common,
        shot: &'a Shot,
        effects: Effects,
        wanted: Wanted,
        timed: bool,
        background: Option<&Picture<[f32; 4]>>,
    ) -> Result<Renderer<'a>, Failure> {
        let headless = Headless::new(&common.device()?)?;
        let messages = headless.messages();
        let mut offline = Offline::new(headless, effects.clone())?;
        let buffers = layers::buffers(&effects, wanted);
        offline.set_layers(&buffers)?;
        match (&shot.background, background) {
            (_, Some(picture)) => offline.set_backdrop(&picture.pixels)?,
            (Background::Colour([r, g, b]), None) => offline.set_background([*r, *g, *b, 1.0]),
            _ => offline.set_background([0.0; 4]),
        }
        check(&messages)?;
        Ok(Renderer { offline, messages, shot, effects, buffers, wanted, timed, remarks: Vec::new() })
    }

    /// The device, and the memory that the effects take, for people.
    pub(super) fn describe(&self) -> String {
        let device = self.offline.device().info().to_string();
        let mebibytes = self.offline.memory().div_ceil(1 << 20);
        format!("device {}; {mebibytes} MiB of its memory", device.trim())
    }

    /// Takes a step, and renders it if that is asked for. With smoke, steps come without gaps from the shot's first frame.
    pub(super) fn step(&mut self, step: &mut Step) -> Result<(Option<Frame>, Option<FrameTimes>), Failure> {
        let Renderer { offline, shot, .. } = self;
        let Step { number, origin, rendered, .. } = *step;
        if let Some(past) = step.past.take()
            && !offline.go_on_from(&past)?
        {
            let why = "what --cache has of the frame before is not of these effects; empty that folder";
            return Err(Failure::new(Failure::DEVICE, format!("frame {number}: {why}")));
        }
        let claim = step.claim.take();
        offline.set_timed(self.timed && rendered);
        let mut scene = program::scene(shot, number, rendered);
        step.put(&mut scene);
        offline.frame(&scene)?;
        check(&self.messages)?;
        if !rendered {
            return Ok((None, offline.times()));
        }
        let offline = &*offline;
        let picture = offline.picture();
        let skipped = |effect: &'static str| offline.skipped(effect).map(move |(pass, _)| (effect, pass));
        let rendered = Rendered {
            effects: &self.effects,
            picture,
            buffers: self.buffers.iter().copied().zip(offline.layers()).collect(),
            brought: step.brought(),
            skipped: EFFECTS.iter().flat_map(|effect| skipped(effect.name())).collect(),
        };
        let remarks = rendered.remarks().into_iter().map(|remark| format!("frame {number}: {remark}"));
        let remarks = remarks.collect();
        let mut layers = rendered.layers(self.wanted);
        if !offline.vectors().is_empty() {
            // As other programs have it, y is up.
            let vectors = offline.vectors().iter().map(|[x, y]| [*x, -*y]).collect();
            layers.push(Layer { name: layers::VECTORS.0, data: LayerData::Vector(vectors) });
        }
        let frame = Frame { number, origin, pixels: picture.to_vec(), layers, camera: shot.camera(number), claim };
        self.remarks = remarks;
        Ok((Some(frame), self.offline.times()))
    }

    /// What the next frame goes on from.
    pub(super) fn past(&mut self) -> Result<Vec<u8>, Failure> {
        Ok(self.offline.past()?)
    }

    /// Whether the device can time passes.
    pub(super) fn has_clock(&self) -> bool {
        self.offline.has_clock()
    }

    /// Remarks on the frame rendered last.
    pub(super) fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
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
