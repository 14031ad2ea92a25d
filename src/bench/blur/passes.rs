//! Pass `passes`: an output from a mesh, and from the passes that a renderer writes of it. The error is how far apart the outlines
//! of the two smears are. The host's time has all that it does for an output, but for reading files: motion, clusters and rows,
//! and for passes the mesh of their pixels.

use std::sync::Arc;
use std::time::Instant;

use super::EFFECT;
use super::draw::LIGHT;
use super::scene::{FULL_HD, SEED, Scene, Take};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::Measured;
use crate::bench::{Outcome, Session};
use crate::blur::motion::PixelClip;
use crate::blur::reference::passes::{Moments, passes};
use crate::blur::reference::raster::Clip;
use crate::blur::{Desc, MOST_TRIANGLES, Settings};
use crate::error::{Error, Result};
use crate::io::passes::PassFrame;
use crate::offline::{BlurError, PassesInput};
use crate::simulate::mesh::Builtin;

const PASS: &str = "passes";
const MESH: &str = "mesh";
const PASSES: &str = "passes";
const VARIANTS: [(&str, ()); 2] = [(MESH, ()), (PASSES, ())];
/// Name and vertices.
const WORKLOADS: [(&str, u32); 2] = [("run", 10_000), ("fox-like", 330)];
/// What `--quick` divides the picture's sides by.
const CUT: u32 = 4;

pub(super) fn measure(session: &mut Session) -> Outcome {
    for (name, vertices) in WORKLOADS {
        let (name, size) = session.picture(name, FULL_HD, CUT);
        let variants = session.wanted(PASS, &name, &VARIANTS);
        if !variants.is_empty() {
            let names: Vec<&str> = variants.iter().map(|(name, ())| *name).collect();
            session.next(&format!("blur passes {name}"))?;
            measure_workload(session, &name, size, vertices, &names)?;
            session.rig.clear();
        }
    }
    Ok(())
}

/// The passes of frames around the interval, in memory.
fn frames(scene: &Scene) -> Vec<Arc<PassFrame>> {
    let clips = |frame: usize| -> Vec<Clip> {
        let projection = PixelClip::new(&scene.views[frame], [0.0; 2], scene.size);
        scene.poses[frame].iter().map(|position| projection.clip(*position).to_array()).collect()
    };
    let clips: Vec<Vec<Clip>> = (scene.current - 2..=scene.current + 3).map(clips).collect();
    let of = |clips: &[Vec<Clip>]| {
        let moments = Moments { before: &clips[0], now: &clips[1], after: &clips[2] };
        let near = PixelClip::new(&scene.views[scene.current], [0.0; 2], scene.size).near;
        Arc::new(passes(scene.mesh.triangles(), scene.mesh.triangle_objects(), moments, scene.size, near).0)
    };
    clips.windows(3).map(of).collect()
}

/// These are in memory: nothing of them can fail to be read.
fn refused(error: BlurError) -> Error {
    match error {
        BlurError::Effect(error) => error,
        BlurError::Read(error) => Error::HostResource { name: "passes", why: error.to_string() },
    }
}

/// Input that has made the output before, as in a sequence.
fn begun(scene: &Scene, frames: &[Arc<PassFrame>]) -> Result<PassesInput> {
    let (frames, first) = (frames.to_vec(), scene.current as u32 - 1);
    let read = move |number: u32| Ok((*frames[(number - first) as usize]).clone());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut input =
        PassesInput::new(read, [first, first + 3], &Settings::default(), scene.size, threads).map_err(refused)?;
    input.frame(first + 1).map_err(refused)?;
    Ok(input)
}

fn measure_workload(session: &mut Session, name: &str, size: [u32; 2], vertices: u32, variants: &[&str]) -> Outcome {
    let scene = Scene::builtin(Builtin::Run, vertices, size)?;
    let (images, settings) = (scene.images([LIGHT; 2]), Settings::default());
    let frames = frames(&scene);
    let number = scene.current as u32 + 1;
    let rig = &mut session.rig;
    let mesh = scene.take(&scene.prepare(&settings)?, Some(&images));
    let of_mesh = rig.effect(scene.desc(&settings, MOST_TRIANGLES))?;
    rig.frame(of_mesh, &mesh.scene())?;
    let outline = contour(&rig.picture(of_mesh)?, size);
    let mut input = begun(&scene, &frames)?;
    let desc = Desc { outer: false, ..input.desc(SEED, false).map_err(refused)? };
    let passes = Take::new(input.frame(number).map_err(refused)?, images.clone());
    let of_passes = rig.effect(desc)?;
    rig.frame(of_passes, &passes.scene())?;
    let error = deviation(&outline, &contour(&rig.picture(of_passes)?, size));
    let is_mesh = |variant: usize| variants[variant] == MESH;
    let times = interleaved(variants.len(), session.quick, |variant| {
        let (effect, take) = if is_mesh(variant) { (of_mesh, &mesh) } else { (of_passes, &passes) };
        let input = if is_mesh(variant) { None } else { Some(begun(&scene, &frames)?) };
        let begin = Instant::now();
        match input {
            Some(mut input) => drop(std::hint::black_box(input.frame(number).map_err(refused)?)),
            None => drop(std::hint::black_box(scene.prepare(&settings)?)),
        }
        let prepared = begin.elapsed().as_secs_f64() * 1e3;
        let time = rig.frame(effect, &take.scene())?;
        Ok(Measured { cpu_ms: time.cpu_ms + prepared, ..time })
    })?;
    for (variant, times) in (0..).zip(&times) {
        let (effect, take) = if is_mesh(variant) { (of_mesh, &mesh) } else { (of_passes, &passes) };
        let accuracy = if is_mesh(variant) { deviation(&outline, &outline) } else { error.clone() };
        let items = take.frame.mesh.triangles().len() as u64;
        let work = session.rig.work_of_frame(effect, &take.scene())?;
        let subject = Subject { pass: PASS, variant: variants[variant].to_owned(), workload: name.to_owned(), items };
        session.rows.push(Row::new(EFFECT, subject, times, &accuracy, work, &session.limits));
    }
    Ok(())
}

/// Pixels that are covered for the most part, and have one beside them that is not.
fn contour(picture: &[[f32; 4]], [width, height]: [u32; 2]) -> Vec<[i64; 2]> {
    let [width, height] = [width, height].map(i64::from);
    let is_covered = |x: i64, y: i64| {
        (0..width).contains(&x) && (0..height).contains(&y) && picture[(y * width + x) as usize][3] > 0.5
    };
    let is_border = |[x, y]: &[i64; 2]| {
        let beside = [[-1, 0], [1, 0], [0, -1], [0, 1]];
        is_covered(*x, *y) && beside.iter().any(|[dx, dy]| !is_covered(x + dx, y + dy))
    };
    (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).filter(is_border).collect()
}

/// Of each pixel of one outline to the nearest of the other, and back.
fn deviation(a: &[[i64; 2]], b: &[[i64; 2]]) -> Accuracy {
    let distances = |from: &[[i64; 2]], to: &[[i64; 2]]| -> Vec<f64> {
        let squared = |[x, y]: &[i64; 2]| to.iter().map(|[u, v]| (x - u).pow(2) + (y - v).pow(2)).min();
        from.iter().filter_map(squared).map(|squared| (squared as f64).sqrt()).collect()
    };
    let of = "outline of the mesh's smear, in pixels".to_owned();
    Deviation::of([distances(a, b), distances(b, a)].concat()).map(|deviation| (deviation, of))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_documented_name_is_there() {
        assert_eq!(VARIANTS.map(|(name, ())| name), ["mesh", "passes"]);
        assert_eq!(WORKLOADS.map(|(name, _)| name), ["run", "fox-like"]);
    }

    #[test]
    fn outlines_are_as_far_apart_as_they_are() {
        let square = |left: usize| {
            let pixel =
                |i: usize| if (left..left + 4).contains(&(i % 12)) && (2..6).contains(&(i / 12)) { 1.0 } else { 0.0 };
            let pixels: Vec<[f32; 4]> = (0..96).map(|i| [pixel(i); 4]).collect();
            contour(&pixels, [12, 8])
        };
        assert_eq!(square(2).len(), 12);
        let max = |a, b| deviation(&square(a), &square(b)).map(|(deviation, _)| deviation.max);
        assert_eq!((max(2, 2), max(2, 5)), (Some(0.0), Some(3.0)));
    }
}
