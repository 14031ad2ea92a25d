//! Pass `frame`: an output, images and poses in, picture out, with what the settings trade. The error is that of the
//! picture with triangles so fine that they follow what is drawn. The host's time has all that it does for an output:
//! clusters, hulls, recording.

use std::time::Instant;

use super::EFFECT;
use super::draw::LIGHT;
use super::scene::{FULL_HD, Scene, Take};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, Measured, Rig};
use crate::bench::{Outcome, Session};
use crate::blur::layout::CONTROL;
use crate::blur::params::Control;
use crate::blur::settings::{Clusters, Completion, Refine};
use crate::blur::{MOST_TRIANGLES, Settings};
use crate::error::Result;
use crate::simulate::mesh::Builtin;

const PASS: &str = "frame";
type Change = fn(Settings) -> Settings;
const VARIANTS: [(&str, Change); 8] = [
    ("default", |settings| settings),
    ("strength 0.5", |settings| Settings { strength: 0.5, ..settings }),
    ("tolerance 4", |settings| Settings { tolerance: 4.0, ..settings }),
    ("tolerance 0.5", |settings| Settings { tolerance: 0.5, ..settings }),
    ("length 15", |settings| Settings { refine: Refine::Length, ..settings }),
    ("no completion", |settings| Settings { completion: Completion::None, ..settings }),
    ("ldf", |settings| Settings { clusters: Clusters::Ldf, ..settings }),
    ("no smoothing", |settings| Settings { seam_smoothing: 0, ..settings }),
];
/// Name, pixels, and what `--quick` divides the sides by.
const WORKLOADS: [(&str, [u32; 2], u32); 2] = [("paper", [512, 512], 2), ("1920x1080", FULL_HD, 4)];
/// Vertices, and those with `--quick`.
const VERTICES: [u32; 2] = [10_000, 2_500];
/// Of the picture that others are compared with, in pixels.
const FINE_TOLERANCE: f32 = 0.1;

pub(super) fn measure(session: &mut Session) -> Outcome {
    for (name, size, cut) in WORKLOADS {
        let (name, size) = session.picture(name, size, cut);
        let variants = session.wanted(PASS, &name, &VARIANTS);
        if !variants.is_empty() {
            session.next(&format!("blur frame {name}"))?;
            measure_workload(session, &name, size, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

type Picture = Vec<[f32; 4]>;

fn measure_workload(session: &mut Session, name: &str, size: [u32; 2], variants: &[&(&str, Change)]) -> Outcome {
    let scene = Scene::builtin(Builtin::Run, VERTICES[usize::from(session.quick)], size)?;
    let images = scene.images([LIGHT; 2]);
    // Settings that differ only in how triangles are divided have one truth.
    let mut truths: Vec<(Settings, Picture)> = Vec::new();
    let mut found = Vec::new();
    for (variant, change) in variants {
        session.next(&format!("blur frame {name}: {variant}"))?;
        let rig = &mut session.rig;
        let settings = change(Settings::default());
        let defaults = Settings::default();
        let fine =
            Settings { refine: Refine::Error, tolerance: FINE_TOLERANCE, edge: defaults.edge, ..settings.clone() };
        let truth = match truths.iter().position(|(known, _)| *known == fine) {
            Some(place) => place,
            None => {
                let picture = render(rig, &scene, &images, &fine)?.2;
                truths.push((fine, picture));
                truths.len() - 1
            }
        };
        let (effect, take, picture) = render(rig, &scene, &images, &settings)?;
        let control: Vec<Control> = rig.read(effect, CONTROL, 1)?;
        let triangles = control.first().map_or(0, |control| control.triangles);
        found.push((effect, take, settings, triangles, accuracy(&picture, &truths[truth].1, &images[1])));
    }
    let rig = &mut session.rig;
    let times = interleaved(variants.len(), session.quick, |i| {
        let (effect, take, settings, ..) = &found[i];
        let begin = Instant::now();
        std::hint::black_box(scene.prepare(settings)?);
        let prepared = begin.elapsed().as_secs_f64() * 1e3;
        let time = rig.frame(*effect, &take.scene())?;
        Ok(Measured { cpu_ms: time.cpu_ms + prepared, ..time })
    })?;
    for (((variant, _), times), (effect, take, _, triangles, accuracy)) in variants.iter().zip(&times).zip(&found) {
        let work = session.rig.work_of_frame(*effect, &take.scene())?;
        let (variant, workload) = ((*variant).to_owned(), name.to_owned());
        let subject = Subject { pass: PASS, variant, workload, items: u64::from(*triangles) };
        session.rows.push(Row::new(EFFECT, subject, times, accuracy, work, &session.limits));
    }
    Ok(())
}

fn render(
    rig: &mut Rig,
    scene: &Scene,
    images: &[Picture; 2],
    settings: &Settings,
) -> Result<(EffectId, Take, Picture)> {
    let prepared = scene.prepare(settings)?;
    let take = scene.take(&prepared, Some(images));
    let effect = rig.effect(scene.desc(settings, MOST_TRIANGLES))?;
    rig.frame(effect, &take.scene())?;
    let picture = rig.picture(effect)?;
    Ok((effect, take, picture))
}

/// Of all channels of the pixels that one of two pictures does not have of frame i + 1.
fn accuracy(picture: &[[f32; 4]], truth: &[[f32; 4]], next: &[[f32; 4]]) -> Accuracy {
    let pixels = picture.iter().zip(truth).zip(next).filter(|((a, b), next)| a != next || b != next);
    let differences = pixels.flat_map(|((a, b), _)| [0, 1, 2, 3].map(|c| f64::from(a[c] - b[c]).abs())).collect();
    let of = format!("tolerance {FINE_TOLERANCE} with the other settings, linear channels 0 to 1 where anything moves");
    Deviation::of(differences).map(|deviation| (deviation, of))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_documented_name_is_there() {
        assert_eq!((VARIANTS[0].0, WORKLOADS.map(|(name, ..)| name)), ("default", ["paper", "1920x1080"]));
    }

    #[test]
    fn pixels_of_the_later_frame_do_not_count() {
        let (moved, still) = ([0.5, 0.0, 0.0, 1.0], [0.0; 4]);
        let found = accuracy(&[moved, still], &[[0.25, 0.0, 0.0, 1.0], still], &[still, still]);
        assert_eq!(found.map(|(deviation, _)| (deviation.max, deviation.rms)), Some((0.25, 0.125)));
        assert!(accuracy(&[still], &[still], &[still]).is_none());
    }
}
