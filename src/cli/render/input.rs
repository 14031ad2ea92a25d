//! Input of frames: that of the shot's effects, read ahead of the renderer.

use std::any::Any;
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use super::Failure;
use super::origin::Origins;
use crate::cli::{Common, memory};
use crate::interrupt;
use crate::io::shot::Shot;
use crate::offline::{Effects, Scene};
use crate::program::{Brought, EFFECTS, Input, InputError};

/// The input of a shot's effects.
pub(super) struct Inputs {
    effects: Vec<Box<dyn Input>>,
    /// Of each, by the effect's name.
    names: Vec<&'static str>,
}

/// A frame, and what it brings.
pub(super) struct Step {
    /// The shot's number of it.
    pub(super) number: u32,
    /// A hash of what it is made from; 0 where it is not rendered.
    pub(super) origin: u128,
    /// Whether it is rendered, or only moves on what has a past.
    pub(super) rendered: bool,
    /// By the effect's name.
    brought: Vec<(&'static str, Box<dyn Brought>)>,
}

/// A step, or why there are no more.
pub(super) type Read = Result<Step, Failure>;

impl Step {
    /// Puts what the frame brings into its scene.
    pub(super) fn put<'a>(&'a self, scene: &mut Scene<'a>) {
        self.brought.iter().for_each(|(_, brought)| brought.put(scene));
    }

    /// Input of the frame, by the effect's name.
    pub(super) fn brought(&self) -> Vec<(&'static str, &dyn Any)> {
        self.brought.iter().map(|(name, brought)| (*name, &**brought as &dyn Any)).collect()
    }
}

impl Inputs {
    /// Of a shot. What frames look like may follow from all of it, which is looked at then.
    pub(super) fn open(shot: &Arc<Shot>) -> Result<Inputs, InputError> {
        let (mut effects, mut names) = (Vec::new(), Vec::new());
        for effect in EFFECTS {
            if let Some(input) = (effect.open)(shot)? {
                effects.push(input);
                names.push(effect.name());
            }
        }
        Ok(Inputs { effects, names })
    }

    /// Of each effect.
    pub(super) fn effects(&self) -> &[Box<dyn Input>] {
        &self.effects
    }

    /// Descriptions of the effects that render the `missing` frames, and keep their layers if that is asked for. Reads
    /// what there must be before.
    pub(super) fn describe(&mut self, missing: &[u32], layers: bool, common: &Common) -> Result<Effects, Failure> {
        self.effects.iter_mut().try_for_each(|effect| effect.prepare(missing, common.threads()))?;
        let mut effects = Effects::default();
        for effect in &mut self.effects {
            effects = effect.describe(effects, missing, layers)?;
        }
        interrupt::check()?;
        Ok(effects)
    }

    /// Parts of the input that are passed over, and the choices where there are several.
    pub(super) fn notes(&self, shot: &Shot) -> Vec<String> {
        let mut notes: Vec<String> = self.effects.iter().flat_map(|effect| effect.notes()).collect();
        notes.extend(camera_notes(shot));
        let mut seen = HashSet::new();
        notes.retain(|note| seen.insert(note.clone()));
        notes
    }

    /// The choices that the shot left to its input, for people.
    pub(super) fn choices(&self) -> String {
        self.effects.iter().filter_map(|effect| effect.choices()).map(|choice| format!("; {choice}")).collect()
    }

    /// Reads what the steps bring that render the `missing` frames, one step ahead of who takes them: what has a past is
    /// stepped from the shot's first frame.
    pub(super) fn read_ahead(mut self, shot: &Shot, mut origins: Origins, missing: &[u32], to: &SyncSender<Read>) {
        let has_past = self.effects.iter().any(|effect| effect.has_past());
        let steps = match missing.last().filter(|_| has_past) {
            Some(last) => (shot.frames[0]..=*last).collect(),
            None => missing.to_vec(),
        };
        for number in steps {
            memory::doing("reading the input of frame", Some(number));
            let step = self.step(number, missing.binary_search(&number).is_ok(), &mut origins);
            let failed = step.is_err();
            // The renderer has gone where nobody takes it.
            if to.send(step).is_err() || failed {
                return;
            }
        }
    }

    fn step(&mut self, number: u32, rendered: bool, origins: &mut Origins) -> Read {
        // The hash first: what is read between it and the check is what it is of.
        let origin = match rendered {
            true => origins.of(number, &self.effects)?,
            false => origins.advance(number, &self.effects).map(|()| 0)?,
        };
        let mut all = Vec::new();
        for (effect, name) in self.effects.iter_mut().zip(&self.names) {
            all.extend(effect.read(number, rendered)?.map(|brought| (*name, brought)));
        }
        origins.check()?;
        Ok(Step { number, origin, rendered, brought: all })
    }
}

/// Of a camera's file nothing else is seen.
fn camera_notes(shot: &Shot) -> Vec<String> {
    let Some(mesh) = shot.camera_scene() else { return Vec::new() };
    let file = mesh.path().display();
    let passed_over = mesh.notes().iter().filter(|note| !note.looks);
    let mut notes: Vec<String> = passed_over.map(|note| format!("{file}: {}", note.text)).collect();
    if let (Some(camera), [_, _, ..]) = (mesh.camera_taken(), mesh.cameras()) {
        let (name, all) = (&camera.name, mesh.cameras().len());
        notes.push(format!("{file}: is seen by its camera `{name}`, of {all}; camera.name names others"));
    }
    notes
}
