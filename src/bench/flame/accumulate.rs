//! Pass `accumulate`: from lists of particles to mean colours. The paper's render passes, the same repetitions tile by
//! tile, their limit by integration, and ways to blend instead. All start from what a frame has prepared: particles,
//! and where it is used lists and the table, which lasts as long as settings do. `sorted` holds the sorting.

use super::EFFECT;
use super::rivals::{Rival, Rivals};
use super::scene::{self, Scene, Workload};
use super::truth::Truth;
use crate::bench::measure::interleaved;
use crate::bench::report::{Row, Subject, Work};
use crate::bench::rig::{EffectId, KernelsId, Measured, Rig};
use crate::bench::{Outcome, Session};
use crate::error::Result;
use crate::flame::Settings;
use crate::flame::settings::{Method, Mode, Sampling};
use crate::plan::Plan;

const PASS: &str = "accumulate";
const VARIANTS: [(&str, Variant); 26] = [
    ("raster R=1", Variant::Raster(1)),
    ("raster R=4", Variant::Raster(4)),
    ("raster R=16", Variant::Raster(16)),
    ("raster R=64", Variant::Raster(64)),
    ("tiles R=1", Variant::Tiles(1)),
    ("tiles R=4", Variant::Tiles(4)),
    ("tiles R=16", Variant::Tiles(16)),
    ("tiles R=20", Variant::Tiles(20)),
    ("tiles R=64", Variant::Tiles(64)),
    ("tiles R=256", Variant::Tiles(256)),
    ("tiles R=1024", Variant::Tiles(1024)),
    ("tiles sobol R=4", Variant::Sobol(4)),
    ("tiles sobol R=16", Variant::Sobol(16)),
    ("tiles sobol R=20", Variant::Sobol(20)),
    ("tiles sobol R=64", Variant::Sobol(64)),
    ("tiles sobol R=256", Variant::Sobol(256)),
    ("tiles sobol R=1024", Variant::Sobol(1024)),
    ("expected 8", Variant::Expected(8)),
    ("expected 16", Variant::Expected(16)),
    ("expected 32", Variant::Expected(32)),
    ("expected 64", Variant::Expected(64)),
    ("sorted", Variant::Rival(Rival::Sorted)),
    ("weighted", Variant::Rival(Rival::Weighted)),
    ("mboit 4", Variant::Rival(Rival::Moments4)),
    ("mboit 6", Variant::Rival(Rival::Moments6)),
    ("wavelet 3", Variant::Rival(Rival::Wavelets)),
];
/// The most repetitions with `--quick`.
const QUICK_REPETITIONS: u64 = 64;
const WORKLOADS: [Workload; 3] = [scene::PAPER, scene::THIN, scene::THICK];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Variant {
    /// Repetitions.
    Raster(u32),
    Tiles(u32),
    Sobol(u32),
    /// Depth bins.
    Expected(u32),
    Rival(Rival),
}

impl Variant {
    fn settings(self, scene: &Scene) -> Settings {
        let settings = scene.settings.clone();
        match self {
            Variant::Raster(repetitions) => Settings { method: Method::Raster, repetitions, ..settings },
            Variant::Tiles(repetitions) => Settings { repetitions, ..settings },
            Variant::Sobol(repetitions) => Settings { sampling: Sampling::ShuffledSobol, repetitions, ..settings },
            Variant::Expected(bins) => Settings { mode: Mode::Expected, bins, ..settings },
            Variant::Rival(_) => Settings { mode: Mode::Expected, ..settings },
        }
    }

    /// The integral, and what is blended, take each render particle once.
    fn repetitions(self) -> u64 {
        match self {
            Variant::Raster(repetitions) | Variant::Tiles(repetitions) | Variant::Sobol(repetitions) => {
                repetitions.into()
            }
            _ => 1,
        }
    }
}

/// The repeated run.
enum Run {
    Effect(EffectId, Plan),
    Kernels(KernelsId, Plan),
}

impl Run {
    fn run(&self, rig: &mut Rig) -> Result<Measured> {
        match self {
            Run::Effect(effect, plan) => rig.replay(*effect, plan),
            Run::Kernels(kernels, plan) => rig.run(*kernels, plan),
        }
    }

    fn work(&self, rig: &mut Rig) -> Result<Work> {
        match self {
            Run::Effect(effect, plan) => rig.work_of_replay(*effect, plan),
            Run::Kernels(kernels, plan) => rig.work_of_run(*kernels, plan),
        }
    }
}

pub(super) fn measure(session: &mut Session) -> Outcome {
    for workload in &WORKLOADS {
        let scene = Scene::new(workload, session.quick);
        let mut variants = session.wanted(PASS, &scene.name, &VARIANTS);
        variants.retain(|(_, variant)| !session.quick || variant.repetitions() <= QUICK_REPETITIONS);
        if !variants.is_empty() {
            session.next(&format!("flame accumulate {}", scene.name))?;
            measure_workload(session, &scene, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

fn measure_workload(session: &mut Session, scene: &Scene, variants: &[&(&str, Variant)]) -> Outcome {
    let truth = Truth::new(scene, session.quick);
    let mut runs = Vec::new();
    let mut accuracies = Vec::new();
    let mut rivals = None;
    for (name, variant) in variants {
        session.next(&format!("flame accumulate {}: {name}", scene.name))?;
        let (run, mean) = prepare(&mut session.rig, scene, *variant, &mut rivals)?;
        runs.push(run);
        accuracies.push(truth.accuracy(&mean));
    }
    let (rig, watch) = (&mut session.rig, session.watch);
    let times = interleaved(variants.len(), session.quick, |i| {
        watch.progress(&format!("flame accumulate {}: {}, timed", scene.name, variants[i].0));
        runs[i].run(rig)
    })?;
    for ((((variant, kind), times), accuracy), run) in variants.iter().zip(&times).zip(&accuracies).zip(&runs) {
        session.next(&format!("flame accumulate {}: {variant}, counted", scene.name))?;
        let work = run.work(&mut session.rig)?;
        let (variant, workload) = ((*variant).to_owned(), scene.name.clone());
        let subject = Subject { pass: PASS, variant, workload, items: kind.repetitions() * truth.sprites };
        session.rows.push(Row::new(EFFECT, subject, times, accuracy, work, &session.limits));
    }
    Ok(())
}

/// Runs a variant once; what to run again, and its mean colours.
fn prepare(
    rig: &mut Rig,
    scene: &Scene,
    variant: Variant,
    rivals: &mut Option<Rivals>,
) -> Result<(Run, Vec<[f32; 4]>)> {
    if let Variant::Rival(rival) = variant {
        let rivals = match rivals {
            Some(rivals) => rivals,
            None => {
                let effect = scene.render(rig, variant.settings(scene))?;
                rivals.insert(Rivals::new(rig, effect, scene)?)
            }
        };
        let plan = rivals.plan(scene, rival);
        rig.run(rivals.kernels(), &plan)?;
        let mean = rivals.mean(rig)?;
        return Ok((Run::Kernels(rivals.kernels(), plan), mean));
    }
    let effect = scene.render(rig, variant.settings(scene))?;
    let plan = rig.steps(effect, |pass| matches!(pass.name, "flame.accumulate" | "flame.raster"));
    let mean = scene.mean(rig, effect)?;
    Ok((Run::Effect(effect, plan), mean))
}

/// What the shape of the kernels is chosen by: repetitions, and the expected image.
pub(super) fn accumulations(rig: &mut Rig, scene: &Scene) -> Result<[(EffectId, Plan); 2]> {
    let mut accumulation = |variant: Variant| {
        let effect = scene.render(rig, variant.settings(scene))?;
        Ok((effect, rig.steps(effect, |pass| pass.name == "flame.accumulate")))
    };
    Ok([accumulation(Variant::Tiles(16))?, accumulation(Variant::Expected(32))?])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names that `bench.json` is documented to have.
    #[test]
    fn every_documented_name_is_there() {
        let runs = |method: &str, repetitions: &[u32]| -> Vec<String> {
            repetitions.iter().map(|r| format!("{method} R={r}")).collect()
        };
        let mut documented = runs("raster", &[1, 4, 16, 64]);
        documented.extend(runs("tiles", &[1, 4, 16, 20, 64, 256, 1024]));
        documented.extend(runs("tiles sobol", &[4, 16, 20, 64, 256, 1024]));
        documented.extend([8, 16, 32, 64].map(|bins| format!("expected {bins}")));
        documented.extend(["sorted", "weighted", "mboit 4", "mboit 6", "wavelet 3"].map(String::from));
        assert_eq!(VARIANTS.map(|(name, _)| name.to_owned()).to_vec(), documented);
        assert_eq!(WORKLOADS.map(|workload| workload.name), ["paper", "thin", "thick"]);
        for workload in &WORKLOADS {
            assert!(Scene::new(workload, true).name.starts_with(workload.name));
        }
    }
}
