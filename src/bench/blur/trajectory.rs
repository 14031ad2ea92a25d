//! Pass `trajectory`: splines through poses on the device, through all frames of a shot or those of a window.

use glam::DVec3;

use super::EFFECT;
use super::scene::{FULL_HD, Scene};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, Rig};
use crate::bench::{Outcome, Session};
use crate::blur::layout::SPLINES;
use crate::blur::params::{PIECE_SEGMENTS, Piece};
use crate::blur::reference::{path, spline};
use crate::blur::settings::Trajectory;
use crate::blur::{Desc, Knot, Settings};
use crate::error::Result;
use crate::offline::BlurFrame;
use crate::plan::Plan;
use crate::random::hash;

const PASS: &str = "trajectory";
/// Frames before frame i and after frame i + 1, as far as there are so many.
type Window = [usize; 2];

const VARIANTS: [(&str, Window); 5] =
    [("whole", [usize::MAX; 2]), ("window 4", [4; 2]), ("window 8", [8; 2]), ("window 12", [12; 2]), ("past", [12, 0])];
const NAME: &str = "100000x48";
const VERTICES: u32 = 100_000;
/// Points whose error is looked at, and with `--quick`.
const CHECKED: [usize; 2] = [4096, 512];

pub(super) fn measure(session: &mut Session) -> Outcome {
    let variants = session.wanted(PASS, NAME, &VARIANTS);
    if !variants.is_empty() {
        session.next(&format!("blur trajectory {NAME}"))?;
        measure_variants(session, &variants)?;
        session.rig.clear();
    }
    Ok(())
}

fn measure_variants(session: &mut Session, variants: &[&(&str, Window)]) -> Outcome {
    let scene = Scene::points(VERTICES, FULL_HD)?;
    let checked = CHECKED[usize::from(session.quick)];
    let rig = &mut session.rig;
    let mut runs: Vec<(EffectId, Plan)> = Vec::new();
    let mut found = Vec::new();
    for (_, window) in variants {
        let (effect, frames) = render(rig, &scene, *window)?;
        let pieces: Vec<Piece> = rig.read(effect, SPLINES, scene.mesh.points())?;
        found.push((accuracy(&scene, &pieces, checked), memory(&scene, frames)));
        runs.push((effect, rig.steps(effect, |pass| pass.name == "blur.trajectory")));
    }
    let times = interleaved(variants.len(), session.quick, |i| rig.replay(runs[i].0, &runs[i].1))?;
    for ((((variant, _), times), (accuracy, bytes)), (effect, plan)) in
        variants.iter().zip(&times).zip(&found).zip(runs)
    {
        let work = session.rig.work_of_replay(effect, &plan)?;
        let (variant, workload) = ((*variant).to_owned(), NAME.to_owned());
        session.notes.push(format!(
            "blur trajectory {NAME}: {variant} takes {:.1} MB and {:.2} ms",
            *bytes as f64 / 1e6,
            times.gpu_ms
        ));
        let subject = Subject { pass: PASS, variant, workload, items: scene.mesh.points() as u64 };
        session.rows.push(Row::new(EFFECT, subject, times, accuracy, work, &session.limits));
    }
    Ok(())
}

/// Bytes of the poses of so many frames, and of the trajectories.
fn memory(scene: &Scene, frames: usize) -> u64 {
    (scene.mesh.points() * (frames * size_of::<[f32; 3]>() + size_of::<Piece>())) as u64
}

/// The output with trajectories through the frames of a window, and how many these are.
fn render(rig: &mut Rig, scene: &Scene, window: Window) -> Result<(EffectId, usize)> {
    let settings = Settings::default();
    let prepared = scene.prepare(&settings)?;
    let knots = knots(scene, window);
    let first = knots.first().map_or(0, |knot| knot.view.frame);
    // The frame after is drawn, too.
    let end = (first as usize + knots.len()).max((scene.current + 3).min(scene.poses.len()));
    let poses = scene.poses[first as usize..end].to_vec();
    let desc = Desc { frames_resident: poses.len() as u32, ..scene.desc(&settings, 1024) };
    let count = knots.len();
    let mut take = scene.take(&prepared, None);
    take.frame = BlurFrame { first, poses, knots: Some(knots), ..take.frame };
    let effect = rig.effect(desc)?;
    rig.frame(effect, &take.scene())?;
    Ok((effect, count))
}

/// The frames of a window, and what each contributes to the piece from frame i to frame i + 1.
fn knots(scene: &Scene, [before, after]: Window) -> Vec<Knot> {
    let last = scene.poses.len() - 1;
    let first = scene.current.saturating_sub(before);
    let end = last.min((scene.current + 1).saturating_add(after));
    let trajectory = if after == 0 { Trajectory::Past } else { Trajectory::Spline };
    let times: Vec<f64> = (first..=end).map(|frame| frame as f64).collect();
    let own = scene.current - first;
    let knot = |place: usize| {
        // The spline is linear in its values: a frame's share is the spline through 1 there and 0 elsewhere.
        let mut values = vec![DVec3::ZERO; times.len()];
        values[place].x = 1.0;
        let bends = spline::second_derivatives(&times, &values, trajectory);
        let step = [own, own + 1].map(|end| f32::from(u8::from(end == place)));
        let mut weights = [[0.0; 4]; PIECE_SEGMENTS as usize];
        weights[0] = [0.0, step[1] - step[0], bends[own].x as f32, bends[own + 1].x as f32];
        Knot { view: scene.view(first + place), weights }
    };
    (0..times.len()).map(knot).collect()
}

/// Of the way from frame i to the middle of the interval, at some points.
fn accuracy(scene: &Scene, pieces: &[Piece], checked: usize) -> Accuracy {
    let held = vec![false; scene.poses.len()];
    let segments = [crate::blur::motion::Segment { begin: 0.0, end: 1.0 }];
    let difference = |i: usize| {
        let point = hash(8, i as u32, 0, 0) as usize % pieces.len();
        let positions: Vec<[f32; 3]> = scene.poses.iter().map(|pose| pose[point]).collect();
        let exact = spline::Path {
            positions: &positions,
            views: &scene.views,
            held: &held,
            size: scene.size,
            on_screen: false,
            trajectory: Trajectory::Spline,
        };
        let i = scene.current as f64;
        let exact = exact.at(i + 0.5).position - exact.at(i).position;
        let found = path::Path { segments: &segments, pieces: &pieces[point..=point], on_screen: false }.moved(0.5);
        (f64::from(found[0]) - exact.x).hypot(f64::from(found[1]) - exact.y)
    };
    let differences = (0..checked.min(pieces.len())).map(difference).collect();
    let of = format!("f64 spline through all frames, px at mid-interval, at {checked} points");
    Deviation::of(differences).map(|deviation| (deviation, of))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_documented_name_is_there() {
        assert_eq!(VARIANTS.map(|(name, _)| name), ["whole", "window 4", "window 8", "window 12", "past"]);
        assert_eq!(NAME, format!("{VERTICES}x48"));
    }

    #[test]
    fn a_window_of_twelve_is_what_the_product_takes() -> Result<()> {
        let scene = Scene::points(100, FULL_HD)?;
        assert_eq!((knots(&scene, [usize::MAX; 2]).len(), memory(&scene, 26)), (48, 100 * (26 * 12 + 64)));
        for (trajectory, window, count) in [(Trajectory::Spline, [12; 2], 26), (Trajectory::Past, [12, 0], 14)] {
            let own = scene.prepare(&Settings { trajectory, ..Settings::default() })?.knots.unwrap_or_default();
            assert_eq!(own.len(), count);
            for (a, b) in own.iter().zip(knots(&scene, window)) {
                assert_eq!(a.view, b.view);
                let differ = a.weights[0].iter().zip(b.weights[0]).any(|(a, b)| (a - b).abs() > 1e-6);
                assert!(!differ, "{:?} {:?}", a.weights[0], b.weights[0]);
            }
        }
        Ok(())
    }
}
