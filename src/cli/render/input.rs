//! Input of frames: that of the shot's effects.

use std::collections::HashSet;
use std::sync::Arc;

use super::Failure;
use crate::cli::Common;
use crate::interrupt;
use crate::io::shot::Shot;
use crate::offline::Effects;
use crate::program::{Brought, EFFECTS, Input, InputError};

/// The input of a shot's effects.
pub(super) struct Inputs {
    effects: Vec<Box<dyn Input>>,
    /// Of each, by the effect's name.
    names: Vec<&'static str>,
}

/// What a frame brings to the effect of a name.
pub(super) type NamedBrought = (&'static str, Box<dyn Brought>);

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

    /// Whether a frame depends on those before it.
    pub(super) fn has_past(&self) -> bool {
        self.effects.iter().any(|effect| effect.has_past())
    }

    /// What a frame brings, by the effect's name.
    pub(super) fn read(&mut self, frame: u32, rendered: bool) -> Result<Vec<NamedBrought>, InputError> {
        let mut all = Vec::new();
        for (effect, name) in self.effects.iter_mut().zip(&self.names) {
            all.extend(effect.read(frame, rendered)?.map(|brought| (*name, brought)));
        }
        Ok(all)
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
