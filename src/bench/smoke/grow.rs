//! Pass `grow`: from density to radii. Up to empty voxels, by the paper's loop, by a distance field, by a pyramid, and by what
//! the effect chooses; up to the surface, as boxes and as balls. The time of each holds all that it needs: occupancy, field or
//! pyramid, and the search.

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
use crate::smoke::reference::{grow, surface};
use crate::smoke::settings::{Grow, Radius, RadiusFrom, Shadow};
use crate::view::Camera;

const PASS: &str = "grow";
/// How far a sphere reaches, and how that is searched.
#[derive(Clone, Copy)]
enum Way {
    Voxels(Grow),
    Surface(Radius),
}

/// The last two are up to the surface.
const VARIANTS: [(&str, Way); 6] = [
    ("growth", Way::Voxels(Grow::Growth)),
    ("field", Way::Voxels(Grow::Field)),
    ("pyramid", Way::Voxels(Grow::Pyramid)),
    ("chosen", Way::Voxels(Grow::Chosen)),
    ("surface", Way::Surface(Radius::Box)),
    ("surface_ball", Way::Surface(Radius::Ball)),
];
/// Passes that lead from density to radii.
const STEPS: [&str; 5] = ["smoke.occupancy", "smoke.pyramid", "smoke.field", "smoke.crossings", "smoke.grow"];
/// Particles whose radius is compared with the brute force, and with the fine search for the surface.
const SAMPLE: u32 = 1000;
const SURFACE_SAMPLE: u32 = 100;
/// Particles of the largest workload that is searched up to the surface: a search is a workgroup.
const MOST_SURFACE: u32 = 10_000;

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
        let variants = if particles > MOST_SURFACE { &VARIANTS[..4] } else { &VARIANTS[..] };
        let variants = session.wanted(PASS, &name, variants);
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
    variants: &[&(&str, Way)],
) -> Outcome {
    let volume = scene::still_plume(dimensions);
    let runs = variants.iter().map(|(_, way)| prepare(&mut session.rig, *way, particles, &volume));
    let runs = runs.collect::<Result<Vec<_>>>()?;
    let rig = &mut session.rig;
    let times = interleaved(variants.len(), session.quick, |i| rig.replay(runs[i].0, &runs[i].1))?;
    for (((variant, way), times), (effect, plan)) in variants.iter().zip(&times).zip(runs) {
        let work = session.rig.work_of_replay(effect, &plan)?;
        let accuracy = accuracy(&mut session.rig, effect, *way, &volume, particles)?;
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
    ways.map(|grow| prepare(rig, Way::Voxels(grow), particles, &volume)).collect()
}

/// A frame, which compiles every kernel, and the steps of it that lead to radii.
fn prepare(rig: &mut Rig, way: Way, particles: u32, volume: &Volume) -> Result<(EffectId, Plan)> {
    let (radius_from, grow, radius) = match way {
        Way::Voxels(grow) => (RadiusFrom::Voxels, grow, Radius::Box),
        Way::Surface(radius) => (RadiusFrom::Surface, Grow::Chosen, radius),
    };
    // Everything that has nothing to do with radii is off.
    let settings = Settings {
        radius_from,
        radius,
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

/// Against the brute force over all voxels in f64, or the fine search for the surface, in voxels.
fn accuracy(rig: &mut Rig, effect: EffectId, way: Way, volume: &Volume, particles: u32) -> Result<Accuracy> {
    let spheres: Vec<[f32; 4]> = rig.read(effect, SPHERES, particles as usize)?;
    let grid = volume.grid();
    let side = grid.smallest_side();
    let (sample, what) = match way {
        Way::Voxels(_) => (SAMPLE, "brute force"),
        Way::Surface(_) => (SURFACE_SAMPLE, "fine search"),
    };
    let every = (particles / sample).max(1) as usize;
    let threshold = Settings::default().threshold;
    let expected = |place| match way {
        Way::Voxels(_) => grow::radius(&grid, threshold, place, Radius::Box),
        Way::Surface(radius) => surface::radius(&grid, threshold, place, radius),
    };
    let difference = |[x, y, z, r]: &[f32; 4]| (f64::from(*r) - expected([*x, *y, *z])).abs() / side;
    let differences: Vec<f64> = spheres.iter().step_by(every).map(difference).collect();
    let of = format!("f64 {what}, radius in voxels, {} particles", differences.len());
    Ok(Deviation::of(differences).map(|deviation| (deviation, of)))
}
