//! Pass `complete`: what replaces colours that one of two frames hides, against the colours that are there: two bars pass
//! each other, and the truth is the rear one without the one before it. The light turns, or nothing would change that
//! could be guessed wrongly. The time of all variants has that of looking colours up, which `none` does, too.

use glam::DQuat;

use super::EFFECT;
use super::draw::LIGHT;
use super::scene::Scene;
use crate::bench::measure::{Deviation, interleaved, oklab};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, Rig};
use crate::bench::{Outcome, Session};
use crate::blur::layout::{COLOUR_LAYER, CONTROL, DISTORTED_NAMES, FINISHED, MASK_LAYER};
use crate::blur::params::{BASE_MASK, Control, SHOWN_BOTH, SHOWN_NEXT, SHOWN_PREVIOUS};
use crate::blur::settings::Completion;
use crate::blur::{Desc, MOST_TRIANGLES, Settings};
use crate::error::Result;
use crate::plan::Plan;
use crate::simulate::mesh::Builtin;

const PASS: &str = "complete";
const NAME: &str = "crossing";
const VARIANTS: [(&str, Completion); 3] =
    [("surface", Completion::Surface), ("gradient", Completion::Gradient), ("none", Completion::None)];
const VERTICES: u32 = 4_000;
/// The earlier frames of the outputs: the rear bar disappears behind the other, and comes out. `--quick` has the first and
/// the last.
const FRAMES: [usize; 6] = [20, 21, 22, 25, 26, 27];
const SIZE: [u32; 2] = [1280, 720];
/// What `--quick` divides its sides by.
const CUT: u32 = 2;
/// Degrees by which the light turns in a frame.
const LIGHT_TURN: f64 = 15.0;
/// The bar before the other.
const FRONT_BAR: u32 = 0;
/// Layer `blur.mask` where one of the frames shows the place.
const ONE_SIDED: [u32; 2] = [SHOWN_PREVIOUS, SHOWN_NEXT];

pub(super) fn measure(session: &mut Session) -> Outcome {
    let (name, size) = session.picture(NAME, SIZE, CUT);
    let variants = session.wanted(PASS, &name, &VARIANTS);
    if !variants.is_empty() {
        session.next(&format!("blur complete {name}"))?;
        measure_variants(session, &name, size, &variants)?;
        session.rig.clear();
    }
    Ok(())
}

/// The distorted mesh alone.
struct Layers {
    colour: Vec<[f32; 4]>,
    mask: Vec<u32>,
    /// Object of each pixel's triangle.
    object: Vec<Option<u32>>,
}

fn measure_variants(session: &mut Session, name: &str, size: [u32; 2], variants: &[&(&str, Completion)]) -> Outcome {
    let mut runs: Vec<(EffectId, Plan)> = Vec::new();
    let mut differences: Vec<Vec<f64>> = vec![Vec::new(); variants.len()];
    let frames = if session.quick { vec![FRAMES[0], FRAMES[FRAMES.len() - 1]] } else { FRAMES.to_vec() };
    for current in frames {
        let scene = Scene { current, ..Scene::builtin(Builtin::Crossing, VERTICES, size)? };
        let open = scene.without(FRONT_BAR)?;
        let (images, open_images) = (images(&scene), images(&open));
        let truth = render(&mut session.rig, &open, &open_images, Completion::None)?.1;
        runs.clear();
        for ((variant, completion), differences) in variants.iter().zip(&mut differences) {
            session.next(&format!("blur complete {name}: {variant}"))?;
            let (effect, layers) = render(&mut session.rig, &scene, &images, *completion)?;
            differences.extend(compare(&layers, &truth, scene.size));
            let names = ["blur.params", "blur.normals", "blur.learn", "blur.tones", "blur.shade", "blur.complete"];
            runs.push((effect, session.rig.steps(effect, |pass| names.contains(&pass.name))));
        }
    }
    let (rig, quick) = (&mut session.rig, session.quick);
    let times = interleaved(variants.len(), quick, |i| rig.replay(runs[i].0, &runs[i].1))?;
    for ((((variant, _), times), differences), (effect, plan)) in variants.iter().zip(&times).zip(differences).zip(runs)
    {
        let work = session.rig.work_of_replay(effect, &plan)?;
        let (count, sum) = (differences.len(), differences.iter().sum::<f64>());
        let mean = sum / count.max(1) as f64;
        session.notes.push(format!("blur complete {name}: {variant} is off by {mean:.3} in the mean"));
        let of = format!("occluder removed, 100 x distance in Oklab, {count} one-sided pixels");
        let accuracy: Accuracy = Deviation::of(differences).map(|deviation| (deviation, of));
        let subject =
            Subject { pass: PASS, variant: (*variant).to_owned(), workload: name.to_owned(), items: count as u64 };
        session.rows.push(Row::new(EFFECT, subject, times, &accuracy, work, &session.limits));
    }
    Ok(())
}

/// Frames under a light that turns.
fn images(scene: &Scene) -> [Vec<[f32; 4]>; 2] {
    let light = |frames: f64| DQuat::from_rotation_y((frames * LIGHT_TURN).to_radians()) * LIGHT;
    scene.images([light(-0.5), light(0.5)])
}

fn render(
    rig: &mut Rig,
    scene: &Scene,
    images: &[Vec<[f32; 4]>; 2],
    completion: Completion,
) -> Result<(EffectId, Layers)> {
    let settings = Settings { completion, ..Settings::default() };
    let prepared = scene.prepare(&settings)?;
    let desc = Desc { layers: true, ..scene.desc(&settings, MOST_TRIANGLES) };
    let effect = rig.effect(desc)?;
    rig.frame(effect, &scene.take(&prepared, Some(images)).scene())?;
    let pixels = scene.size[0] as usize * scene.size[1] as usize;
    let control: Vec<Control> = rig.read(effect, CONTROL, 1)?;
    let triangles = control.first().map_or(0, |control| control.triangles);
    let triangles: Vec<[u32; 4]> = rig.read(effect, FINISHED, triangles as usize)?;
    let object = |name: &u32| {
        let triangle = triangles.get((*name as usize).checked_sub(1)?)?;
        scene.mesh.triangle_objects().get((triangle[3] & BASE_MASK) as usize).copied()
    };
    let names: Vec<u32> = rig.read(effect, DISTORTED_NAMES, pixels)?;
    let layers = Layers {
        colour: rig.read(effect, COLOUR_LAYER, pixels)?,
        mask: rig.read(effect, MASK_LAYER, pixels)?,
        object: names.iter().map(object).collect(),
    };
    Ok((effect, layers))
}

/// Of the pixels of the rear bar, away from borders, that one frame shows because of the other bar: without it, both do.
/// Which these are does not depend on what replaces what is hidden, so all variants are judged by the same ones. There the
/// truth is the mixture of what the surface looks like in both frames.
fn compare(found: &Layers, truth: &Layers, [width, height]: [u32; 2]) -> Vec<f64> {
    let (width, height) = (width as usize, height as usize);
    let is_rear =
        |pixel: usize| [found, truth].iter().all(|layers| layers.object[pixel].is_some_and(|o| o != FRONT_BAR));
    let inside = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| y * width + x));
    let counted = inside.filter(|pixel| {
        let mut around = [pixel - width, *pixel, pixel + width].into_iter().flat_map(|row| row - 1..=row + 1);
        ONE_SIDED.contains(&found.mask[*pixel]) && truth.mask[*pixel] == SHOWN_BOTH && around.all(is_rear)
    });
    counted.map(|pixel| 100.0 * oklab(found.colour[pixel]).distance(oklab(truth.colour[pixel]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_documented_name_is_there() {
        assert_eq!((NAME, VARIANTS.map(|(name, _)| name)), ("crossing", ["surface", "gradient", "none"]));
    }

    #[test]
    fn only_one_sided_pixels_inside_the_rear_bar_count() {
        let layers = |red: f32, mask: u32| Layers {
            colour: vec![[red, 0.0, 0.0, 1.0]; 36],
            mask: (0..36).map(|i| if [8, 15, 28].contains(&i) { mask } else { 3 }).collect(),
            object: (0..36).map(|i| Some(u32::from(i != 1))).collect(),
        };
        let mut truth = layers(0.0, 3);
        truth.mask[28] = 2;
        let found = compare(&layers(1.0, 1), &truth, [6, 6]);
        assert_eq!(found.len(), 1, "8 is beside the front bar, 28 is hidden by something else");
        assert!((found[0] - 67.9).abs() < 0.1, "{found:?}");
    }
}
