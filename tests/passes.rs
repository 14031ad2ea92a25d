//! Smears from a renderer's passes against those from the mesh that it rendered.
#![cfg(feature = "cli")]

mod common;

use celfx::blur::motion::PixelClip;
use celfx::blur::reference::passes::{Moments, passes};
use celfx::blur::{BlurKind, Desc, Settings};
use celfx::effect::Effort;
use celfx::io::passes::PassFrame;
use celfx::io::picture::{Format, write};
use celfx::low_level::blur::layout::COLOUR_LAYER;
use celfx::offline::{BlurFrame, BlurInput, BlurScene, EffectBuffer, PassesInput, Scene};
use celfx::program;

const NUMBER: u32 = 24;

type Picture = Vec<[f32; 4]>;

/// A shot of the program, drawn.
struct Film {
    shot: std::sync::Arc<celfx::io::shot::Shot>,
    settings: Settings,
}

impl Film {
    fn new(sets: &[&str]) -> Film {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let shot = std::sync::Arc::new(program::load("builtin:blur", &sets).expect("a shot"));
        let settings = shot.part::<program::blur::Blur>().expect("a blur").settings.clone();
        Film { shot, settings }
    }

    fn input(&self, settings: &Settings) -> BlurInput {
        let blur = self.shot.part::<program::blur::Blur>().expect("a blur");
        let scene = blur.mesh(&self.shot).expect("a scene");
        let (of_shot, size) = (self.shot.clone(), self.shot.size);
        let view = move |frame: f64| of_shot.camera(frame).view(size);
        BlurInput::new(scene, view, self.shot.frames, settings, size, 2).expect("motion")
    }

    /// The frames as they are drawn, without blur.
    fn drawn(&self, frames: std::ops::RangeInclusive<u32>) -> Option<Vec<Picture>> {
        let settings = Settings { strength: 0.0, ..self.settings.clone() };
        let mut input = self.input(&settings);
        let desc = input.desc(self.shot.size, self.shot.frames, 0, true, false);
        let mut offline = common::device()?.offline(desc, Effort::Needed).expect("an effect");
        let mut draw = |number: u32| {
            let frame = input.frame(number).expect("a frame");
            let blur = Some(BlurScene { frame: &frame, images: [None; 2], outer: [None; 2] });
            let (camera, light) = (self.shot.camera(number), self.shot.light(number));
            let scene = Scene { camera, light, blur, rendered: true, number, ..Scene::default() };
            offline.frame(&scene).expect("rendered");
            offline.picture().to_vec()
        };
        Some(frames.map(&mut draw).collect())
    }

    /// Passes of a frame.
    fn passes(&self, number: u32) -> PassFrame {
        let blur = self.shot.part::<program::blur::Blur>().expect("a blur");
        let scene = blur.mesh(&self.shot).expect("a scene");
        let topology = scene.topology();
        let clips = |frame: u32| {
            let view = self.shot.camera(frame).view(self.shot.size);
            let projection = PixelClip::new(&view, [0.0; 2], self.shot.size);
            let pose = scene.pose(f64::from(frame)).expect("a pose");
            pose.iter().map(|position| projection.clip(*position).to_array()).collect::<Vec<_>>()
        };
        let [before, now, after] = [number - 1, number, number + 1].map(clips);
        let objects: Vec<u32> = topology.triangles.iter().map(|t| topology.object[t[0] as usize]).collect();
        let moments = Moments { before: &before, now: &now, after: &after };
        passes(&topology.triangles, &objects, moments, self.shot.size, 0.1).0
    }

    /// An output from images of frames i - 1 to i + 2: the picture, and the colours of the smeared mesh alone.
    fn output(&self, desc: Desc, frame: &BlurFrame, images: &[Picture]) -> Option<[Picture; 2]> {
        let size = self.shot.size;
        let mut offline = common::device()?.offline(desc, Effort::Needed).expect("an effect");
        let image = |place: usize| Some(&images[place][..]);
        let blur = Some(BlurScene { frame, images: [image(1), image(2)], outer: [image(0), image(3)] });
        offline.frame(&Scene { blur, rendered: true, ..Scene::default() }).expect("rendered");
        let pixels = size[0] as usize * size[1] as usize;
        let colours = offline.read_as(EffectBuffer::of::<BlurKind>(COLOUR_LAYER), pixels).expect("read");
        Some([offline.picture().to_vec(), colours])
    }
}

/// Pixels that are covered for the most part and have one beside them that is not.
fn contour(colours: &[[f32; 4]], [width, height]: [u32; 2]) -> Vec<[i32; 2]> {
    let is_covered = |x: i32, y: i32| {
        let is_inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
        is_inside && colours[(y * width as i32 + x) as usize][3] > 0.5
    };
    let pixels = (0..height as i32).flat_map(|y| (0..width as i32).map(move |x| [x, y]));
    let beside = [[-1, 0], [1, 0], [0, -1], [0, 1]];
    pixels.filter(|[x, y]| is_covered(*x, *y) && beside.iter().any(|[dx, dy]| !is_covered(x + dx, y + dy))).collect()
}

/// Distances of two contours, from each pixel of one to the nearest of the other and back, ascending.
fn distances(a: &[[i32; 2]], b: &[[i32; 2]]) -> Vec<f64> {
    let one = |from: &[[i32; 2]], to: &[[i32; 2]]| -> Vec<f64> {
        let nearest =
            |[x, y]: &[i32; 2]| to.iter().map(|[u, v]| (x - u).pow(2) + (y - v).pow(2)).min().unwrap_or(i32::MAX);
        from.iter().map(|pixel| f64::from(nearest(pixel)).sqrt()).collect()
    };
    let mut all = [one(a, b), one(b, a)].concat();
    all.sort_by(f64::total_cmp);
    all
}

fn share(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

#[test]
fn probe() {
    for sets in [&["blur.teeth=1"][..], &[], &["blur.teeth=1", "size=[1280, 720]"]] {
        let film = Film::new(sets);
        let size = film.shot.size;
        let Some(images) = film.drawn(NUMBER - 2..=NUMBER + 1) else { return };
        let frames: std::collections::BTreeMap<u32, PassFrame> =
            (NUMBER - 2..=NUMBER + 2).map(|number| (number, film.passes(number))).collect();
        let mut mesh = film.input(&film.settings);
        let desc = mesh.desc(size, film.shot.frames, 0, false, true);
        let begin = std::time::Instant::now();
        let frame = mesh.frame(NUMBER).expect("a frame");
        eprintln!("mesh {:?}", begin.elapsed());
        let begin = std::time::Instant::now();
        let of_mesh = film.output(desc, &frame, &images).expect("a device");
        eprintln!("mesh output {:?}", begin.elapsed());
        let clock = celfx::io::scene::Clock { first: 1, fps: 24.0 };
        let scene = celfx::io::scene::AnimatedMesh::builtin(celfx::simulate::mesh::Builtin::Run, 7000, clock);
        let of_shot = film.shot.clone();
        let view = move |frame: f64| of_shot.camera(frame).view(of_shot.size);
        let mut other = BlurInput::new(scene, view, film.shot.frames, &film.settings, size, 2).expect("motion");
        let desc = other.desc(size, film.shot.frames, 0, false, true);
        let of_other = film.output(desc, &other.frame(NUMBER).expect("a frame"), &images).expect("a device");
        let read = move |number: u32| Ok(frames[&number].clone());
        let mut input = PassesInput::new(read, film.shot.frames, &film.settings, size, 2).expect("passes");
        let desc = input.desc(0, true).expect("a description");
        let begin = std::time::Instant::now();
        let frame = input.frame(NUMBER).expect("a frame");
        eprintln!(
            "passes {:?} points {} triangles {}",
            begin.elapsed(),
            frame.mesh.points(),
            frame.mesh.triangles().len()
        );
        let begin = std::time::Instant::now();
        input.frame(NUMBER + 1).ok();
        eprintln!("passes next {:?}", begin.elapsed());
        let begin = std::time::Instant::now();
        let of_passes = film.output(desc, &frame, &images).expect("a device");
        eprintln!("passes output {:?}", begin.elapsed());
        if let Ok(folder) = std::env::var("CELFX_SEE") {
            for (name, pictures) in [("mesh", &of_mesh), ("passes", &of_passes)] {
                for (what, picture) in ["picture", "colour"].iter().zip(pictures) {
                    let path = std::path::Path::new(&folder).join(format!("{name}_{what}_{}.png", sets.len()));
                    write(&path, Format::Png, size, picture, None).expect("written");
                }
            }
        }
        let [a, b, c] = [&of_mesh[1], &of_passes[1], &of_other[1]].map(|colours| contour(colours, size));
        for (name, other) in [("passes", &b), ("other mesh", &c)] {
            let found = distances(&a, other);
            eprintln!(
                "{sets:?} {name}: p50 {} p90 {} p95 {} p99 {} max {}",
                share(&found, 0.5),
                share(&found, 0.9),
                share(&found, 0.95),
                share(&found, 0.99),
                share(&found, 1.0)
            );
        }
    }
}
