//! Pass `frame`: a whole frame, particles in, picture out, with what the settings trade. The error is that of the mean
//! colours against what repetitions converge to.

use super::EFFECT;
use super::scene::{self, Scene, Workload};
use super::truth::Truth;
use crate::bench::measure::interleaved;
use crate::bench::report::{Row, Subject};
use crate::bench::rig::{EffectId, Rig};
use crate::bench::{Outcome, Session};
use crate::error::Result;
use crate::flame::Settings;
use crate::flame::layout::{CONTROL, OCCUPIED_TILES, TILE_REPETITIONS};
use crate::flame::params::{Control, TILE};
use crate::flame::settings::{Look, Mode, Sampling};

const PASS: &str = "frame";
type Change = fn(Settings) -> Settings;
const VARIANTS: [(&str, Change); 7] = [
    ("default", |settings| settings),
    ("R=1", |settings| Settings { repetitions: 1, ..settings }),
    ("R=10", |settings| Settings { repetitions: 10, ..settings }),
    ("sobol", |settings| Settings { sampling: Sampling::ShuffledSobol, ..settings }),
    ("expected", |settings| Settings { mode: Mode::Expected, ..settings }),
    ("cel", |settings| Settings { look: Look::Cel, ..settings }),
    ("adaptive 0.1", |settings| Settings { adaptive: 0.1, repetitions: 64, ..settings }),
];
const WORKLOADS: [Workload; 2] = [scene::PAPER, scene::FULL_HD];

pub(super) fn measure(session: &mut Session) -> Outcome {
    for workload in &WORKLOADS {
        let scene = Scene::new(workload, session.quick);
        let variants = session.wanted(PASS, &scene.name, &VARIANTS);
        if !variants.is_empty() {
            session.next(&format!("flame frame {}", scene.name))?;
            measure_workload(session, &scene, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

fn measure_workload(session: &mut Session, scene: &Scene, variants: &[&(&str, Change)]) -> Outcome {
    let truth = Truth::new(scene, session.quick);
    let rig = &mut session.rig;
    let mut effects = Vec::new();
    let mut found = Vec::new();
    for (_, change) in variants {
        let settings = change(scene.settings.clone());
        let (mode, is_cel) = (settings.mode, settings.is_cel());
        let effect = scene.render(rig, settings)?;
        let repetitions = if mode == Mode::Expected { 1.0 } else { mean_repetitions(rig, effect, scene)? };
        // Tones are no means of colours.
        let accuracy = if is_cel { None } else { truth.accuracy(&scene.mean(rig, effect)?) };
        found.push((accuracy, repetitions));
        effects.push(effect);
    }
    let next = scene.scene();
    let times = interleaved(variants.len(), session.quick, |i| rig.frame(effects[i], &next))?;
    for ((((variant, _), times), (accuracy, repetitions)), effect) in
        variants.iter().zip(&times).zip(&found).zip(effects)
    {
        let work = session.rig.work_of_frame(effect, &next)?;
        let (variant, workload) = ((*variant).to_owned(), scene.name.clone());
        let items = (truth.sprites as f64 * repetitions).round() as u64;
        let subject = Subject { pass: PASS, variant, workload, items };
        session.rows.push(Row::new(EFFECT, subject, times, accuracy, work, &session.limits));
    }
    Ok(())
}

/// Repetitions of the frame recorded last, averaged over its tiles: `adaptive` has more where there is more noise.
fn mean_repetitions(rig: &mut Rig, effect: EffectId, scene: &Scene) -> Result<f64> {
    let tiles = scene.size.map(|side| side.div_ceil(TILE) as usize);
    let control: Vec<Control> = rig.read(effect, CONTROL, 1)?;
    let occupied = control.first().map_or(0, |control| control.tile_groups[0]) as usize;
    let occupied: Vec<u32> = rig.read(effect, OCCUPIED_TILES, occupied)?;
    let repetitions: Vec<u32> = rig.read(effect, TILE_REPETITIONS, tiles[0] * tiles[1])?;
    let sum: u64 = occupied.iter().filter_map(|tile| repetitions.get(*tile as usize)).map(|r| u64::from(*r)).sum();
    Ok(sum as f64 / occupied.len().max(1) as f64)
}
