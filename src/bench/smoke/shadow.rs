//! Pass `shadow`: exact shadows and shadow maps, against exact shadows in f64. The time holds the shadow's own steps and
//! the shading of the pixels that are seen, which asks for it.

use super::{EFFECT, scene};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, Rig};
use crate::bench::{Outcome, Session};
use crate::data::Volume;
use crate::error::Result;
use crate::smoke::Settings;
use crate::smoke::layout::{DEPTH, SHADOW};
use crate::smoke::reference::{render, shadow};
use crate::smoke::settings::Shadow;
use crate::view::Light;

const PASS: &str = "shadow";
const VARIANTS: [(&str, (Shadow, u32)); 4] = [
    ("exact", (Shadow::Exact, 16)),
    ("map 1024", (Shadow::Map, 1024)),
    ("map 2048", (Shadow::Map, 2048)),
    ("map 4096", (Shadow::Map, 4096)),
];
/// The most texels a side of a map with `--quick`.
const QUICK_MAP: u32 = 2048;
/// Name, pixels, and what `--quick` divides the sides by.
const WORKLOADS: [(&str, [u32; 2], u32); 2] = [("paper", scene::PAPER, 1), ("1920x1080", scene::FULL_HD, 4)];
const PARTICLES: u32 = 500;
/// Relative difference of depth up to which device and reference see the same sphere at a pixel.
const SAME_DEPTH: f64 = 1e-4;

/// The true values at the pixels that face the light.
struct Truth {
    depth: Vec<f64>,
    shadow: Vec<f64>,
    faces_light: Vec<bool>,
}

pub(super) fn measure(session: &mut Session) -> Outcome {
    for (name, size, cut) in WORKLOADS {
        let (name, size) = session.picture(name, size, cut);
        let mut variants = session.wanted(PASS, &name, &VARIANTS);
        variants.retain(|(_, (_, side))| !session.quick || *side <= QUICK_MAP);
        if !variants.is_empty() {
            session.next(&format!("smoke shadow {name}"))?;
            measure_workload(session, &name, size, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

fn measure_workload(session: &mut Session, name: &str, size: [u32; 2], variants: &[&(&str, (Shadow, u32))]) -> Outcome {
    let volume = scene::still_plume(scene::PAPER_VOXELS);
    let settings =
        |(shadow, shadow_map)| Settings { particles: PARTICLES, fade: 0, shadow, shadow_map, ..Settings::default() };
    let mut truth = None;
    let mut accuracies = Vec::new();
    for (_, kind) in variants {
        accuracies.push(accuracy(&mut session.rig, &volume, size, settings(*kind), &mut truth)?);
        session.rig.clear();
    }
    let mut effects = Vec::new();
    for (_, kind) in variants {
        let effect = session.rig.effect(scene::desc(size, &volume, settings(*kind), false))?;
        session.rig.frame(effect, &scene::first_scene(scene::camera(), &volume))?;
        let plan = session.rig.steps(effect, |pass| matches!(pass.name, "smoke.shadow" | "smoke.luminance"));
        effects.push((effect, plan));
    }
    let rig = &mut session.rig;
    let times = interleaved(variants.len(), session.quick, |i| rig.replay(effects[i].0, &effects[i].1))?;
    for ((((variant, _), times), accuracy), (effect, plan)) in variants.iter().zip(&times).zip(&accuracies).zip(effects)
    {
        let work = session.rig.work_of_replay(effect, &plan)?;
        let (variant, workload) = ((*variant).to_owned(), name.to_owned());
        let subject = Subject { pass: PASS, variant, workload, items: PARTICLES.into() };
        session.rows.push(Row::new(EFFECT, subject, times, accuracy, work, &session.limits));
    }
    Ok(())
}

/// Of the share of light at each pixel; an effect of its own keeps it, which costs time.
fn accuracy(
    rig: &mut Rig,
    volume: &Volume,
    size: [u32; 2],
    settings: Settings,
    truth: &mut Option<Truth>,
) -> Result<Accuracy> {
    let effect = rig.effect(scene::desc(size, volume, settings, true))?;
    rig.frame(effect, &scene::first_scene(scene::camera(), volume))?;
    let truth = match truth {
        Some(truth) => truth,
        None => truth.insert(Truth::new(rig, effect, size)?),
    };
    let pixels = truth.depth.len();
    let depth: Vec<f32> = rig.read(effect, DEPTH, pixels)?;
    let share: Vec<f32> = rig.read(effect, SHADOW, pixels)?;
    let same = |pixel: &usize| {
        let (depth, expected) = (f64::from(depth[*pixel]), truth.depth[*pixel]);
        truth.faces_light[*pixel] && (depth - expected).abs() <= SAME_DEPTH * expected
    };
    let difference = |pixel: usize| (f64::from(share[pixel]) - truth.shadow[pixel]).abs();
    let differences: Vec<f64> = (0..pixels.min(depth.len()).min(share.len())).filter(same).map(difference).collect();
    let of = format!("exact shadows in f64, share of light at {} pixels that face it", differences.len());
    Ok(Deviation::of(differences).map(|deviation| (deviation, of)))
}

impl Truth {
    fn new(rig: &mut Rig, effect: EffectId, size: [u32; 2]) -> Result<Truth> {
        let (spheres, _) = scene::spheres(rig, effect, PARTICLES, 0)?;
        let (view, light) = (scene::camera().view(size), Light::default());
        let hits = render::raycast(&view, size, &spheres);
        let lit = Light { ambient: 0.0, fill: 0.0, ..light };
        let open = vec![1.0; hits.len()];
        let facing = render::luminance(&view, size, &spheres, &hits, &lit, &open);
        Ok(Truth {
            depth: render::depth(&hits),
            shadow: shadow::shadow(&view, size, &spheres, &hits, light.source, 0.0),
            faces_light: facing.iter().map(|facing| *facing > 0.0).collect(),
        })
    }
}
