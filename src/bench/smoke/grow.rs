//! Pass `grow`: from density to radii, by the paper's loop, by a distance field, by a pyramid, and by what the effect
//! chooses. The time of each holds all that it needs: occupancy, field or pyramid, and the search.

use super::{EFFECT, scene};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, Rig};
use crate::bench::{Outcome, Session};
use crate::data::Volume;
use crate::error::Result;
use crate::offline;
use crate::plan::Plan;
use crate::smoke::Settings;
use crate::smoke::layout::SPHERES;
use crate::smoke::reference::grow;
use crate::smoke::settings::{Grow, Radius, RadiusFrom, Shadow};
use crate::view::Camera;

const PASS: &str = "grow";
const VARIANTS: [(&str, Grow); 4] =
    [("growth", Grow::Growth), ("field", Grow::Field), ("pyramid", Grow::Pyramid), ("chosen", Grow::Chosen)];
/// Passes that lead from density to radii.
const STEPS: [&str; 4] = ["smoke.occupancy", "smoke.pyramid", "smoke.field", "smoke.grow"];
/// Particles whose radius is compared with the brute force.
const SAMPLE: u32 = 1000;

struct Workload {
    name: &'static str,
    dimensions: [u32; 3],
    particles: u32,
    /// Its cut with `--quick`.
    cut: Option<([u32; 3], u32)>,
}

const WORKLOADS: [Workload; 4] = [
    Workload { name: "15x15x20/500", dimensions: scene::PAPER_VOXELS, particles: 500, cut: None },
    Workload { name: "64^3/1000", dimensions: [64; 3], particles: 1000, cut: None },
    Workload { name: "128^3/10000", dimensions: [128; 3], particles: 10_000, cut: None },
    Workload { name: "256^3/1000000", dimensions: [256; 3], particles: 1_000_000, cut: Some(([128; 3], 50_000)) },
];

pub(super) fn measure(session: &mut Session) -> Outcome {
    for workload in &WORKLOADS {
        let (mut name, mut dimensions, mut particles) =
            (workload.name.to_owned(), workload.dimensions, workload.particles);
        if let (true, Some((fewer_voxels, fewer))) = (session.quick, workload.cut) {
            (dimensions, particles) = (fewer_voxels, fewer);
            name += &format!(" (cut to {}^3/{fewer})", fewer_voxels[0]);
        }
        let variants = session.wanted(PASS, &name, &VARIANTS);
        if !variants.is_empty() {
            session.next(&format!("smoke grow {name}"))?;
            measure_workload(session, &name, dimensions, particles, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

fn measure_workload(
    session: &mut Session,
    name: &str,
    dimensions: [u32; 3],
    particles: u32,
    variants: &[&(&str, Grow)],
) -> Outcome {
    let volume = scene::still_plume(dimensions);
    let runs = variants.iter().map(|(_, grow)| prepare(&mut session.rig, *grow, particles, &volume));
    let runs = runs.collect::<Result<Vec<_>>>()?;
    let rig = &mut session.rig;
    let times = interleaved(variants.len(), session.quick, |i| rig.replay(runs[i].0, &runs[i].1))?;
    for (((variant, _), times), (effect, plan)) in variants.iter().zip(&times).zip(runs) {
        let work = session.rig.work_of_replay(effect, &plan)?;
        let accuracy = accuracy(&mut session.rig, effect, &volume, particles)?;
        let (variant, workload) = ((*variant).to_owned(), name.to_owned());
        let subject = Subject { pass: PASS, variant, workload, items: particles.into() };
        session.rows.push(Row::new(EFFECT, subject, times, &accuracy, work, &session.limits));
    }
    Ok(())
}

/// The searches by field, by pyramid and, if asked for, by the paper's loop, in a cube.
pub(in crate::bench) fn searches(
    rig: &mut Rig,
    side: u32,
    particles: u32,
    has_growth: bool,
) -> Result<Vec<(EffectId, Plan)>> {
    let volume = scene::still_plume([side; 3]);
    let ways = [Grow::Field, Grow::Pyramid].into_iter().chain(has_growth.then_some(Grow::Growth));
    ways.map(|grow| prepare(rig, grow, particles, &volume)).collect()
}

/// A frame, which compiles every kernel, and the steps of it that lead to radii.
fn prepare(rig: &mut Rig, grow: Grow, particles: u32, volume: &Volume) -> Result<(EffectId, Plan)> {
    // Everything that has nothing to do with radii is off.
    let settings = Settings {
        radius_from: RadiusFrom::Voxels,
        detail: Some(0.0),
        grow,
        particles,
        fade: 0,
        shadow: Shadow::None,
        sigma: 0.0,
        ..Settings::default()
    };
    let effect = rig.effect(scene::desc([16, 16], volume, settings, false))?;
    let first = scene::first_scene(Camera::default(), volume);
    rig.frame(effect, &offline::Scene { rendered: false, ..first })?;
    Ok((effect, rig.steps(effect, |pass| STEPS.contains(&pass.name))))
}

/// Against the brute force over all voxels in f64, in voxels.
fn accuracy(rig: &mut Rig, effect: EffectId, volume: &Volume, particles: u32) -> Result<Accuracy> {
    let spheres: Vec<[f32; 4]> = rig.read(effect, SPHERES, particles as usize)?;
    let grid = volume.grid();
    let side = grid.smallest_side();
    let every = (particles / SAMPLE).max(1) as usize;
    let threshold = Settings::default().threshold;
    let difference = |[x, y, z, r]: &[f32; 4]| {
        (f64::from(*r) - grow::radius(&grid, threshold, [*x, *y, *z], Radius::Box)).abs() / side
    };
    let differences: Vec<f64> = spheres.iter().step_by(every).map(difference).collect();
    let of = format!("f64 brute force, radius in voxels, {} particles", differences.len());
    Ok(Deviation::of(differences).map(|deviation| (deviation, of)))
}
