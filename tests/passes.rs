//! Smears from a renderer's passes against those from the mesh that it rendered.
#![cfg(feature = "cli")]

mod common;

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use celfx::blur::motion::PixelClip;
use celfx::blur::reference::passes::{Moments, passes};
use celfx::blur::{BlurKind, Desc, Settings};
use celfx::effect::Effort;
use celfx::io::display::Display;
use celfx::io::image::write_exr_channels;
use celfx::io::passes::PassFrame;
use celfx::io::picture::{Format, read, write};
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

    /// Frames as the program draws them, smeared or not: the picture, and the colours of the mesh alone.
    fn drawn(&self, settings: &Settings, frames: RangeInclusive<u32>) -> Option<Vec<[Picture; 2]>> {
        let mut input = self.input(settings);
        let desc = input.desc(self.shot.size, self.shot.frames, 0, true, true);
        let mut offline = common::device()?.offline(desc, Effort::Needed).expect("an effect");
        let mut draw = |number: u32| {
            let frame = input.frame(number).expect("a frame");
            let blur = Some(BlurScene { frame: &frame, images: [None; 2], outer: [None; 2] });
            let (camera, light) = (self.shot.camera(number), self.shot.light(number));
            let scene = Scene { camera, light, blur, rendered: true, number, ..Scene::default() };
            offline.frame(&scene).expect("rendered");
            let colours = offline.read_as(EffectBuffer::of::<BlurKind>(COLOUR_LAYER), self.pixels()).expect("read");
            [offline.picture().to_vec(), colours]
        };
        Some(frames.map(&mut draw).collect())
    }

    /// The frames around the one that is made, without blur.
    fn images(&self) -> Option<Vec<Picture>> {
        let settings = Settings { strength: 0.0, ..self.settings.clone() };
        let drawn = self.drawn(&settings, NUMBER - 2..=NUMBER + 1)?;
        Some(drawn.into_iter().map(|[picture, _]| picture).collect())
    }

    fn pixels(&self) -> usize {
        self.shot.size[0] as usize * self.shot.size[1] as usize
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
        let mut offline = common::device()?.offline(desc, Effort::Needed).expect("an effect");
        let image = |place: usize| Some(&images[place][..]);
        let blur = Some(BlurScene { frame, images: [image(1), image(2)], outer: [image(0), image(3)] });
        offline.frame(&Scene { blur, rendered: true, ..Scene::default() }).expect("rendered");
        let colours = offline.read_as(EffectBuffer::of::<BlurKind>(COLOUR_LAYER), self.pixels()).expect("read");
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

/// Passes of frames around the one that is made.
fn all_passes(film: &Film) -> BTreeMap<u32, PassFrame> {
    (NUMBER - 3..=NUMBER + 1).map(|number| (number, film.passes(number))).collect()
}

fn input(film: &Film, frames: BTreeMap<u32, PassFrame>) -> PassesInput {
    let read = move |number: u32| Ok(frames[&number].clone());
    PassesInput::new(read, film.shot.frames, &film.settings, film.shot.size, 2).expect("settings")
}

/// Mean error of colours where two smears and the truth cover a pixel, and it is not frame i + 1's: of linear channels, of each.
fn colour_errors(made: [&[Picture; 2]; 2], truth: &[Picture; 2], next: &Picture) -> [f64; 2] {
    let is_covered = |of: &[Picture; 2], pixel: usize| of[1][pixel][3] > 0.99;
    let is_counted = |pixel: &usize| {
        truth[0][*pixel] != next[*pixel]
            && is_covered(truth, *pixel)
            && made.iter().all(|made| is_covered(made, *pixel))
    };
    let pixels: Vec<usize> = (0..next.len()).filter(is_counted).collect();
    assert!(pixels.len() > 1000, "{}", pixels.len());
    made.map(|made| {
        let off =
            |pixel: &usize| (0..3).map(|c| f64::from((made[0][*pixel][c] - truth[0][*pixel][c]).abs())).sum::<f64>();
        pixels.iter().map(off).sum::<f64>() / (3 * pixels.len()) as f64
    })
}

/// With one tooth a part: where teeth begin depends on what a mesh has and no pixel shows. Without ink, the truth is what is drawn
/// with hidden colours known.
#[test]
fn smears_of_passes_are_those_of_the_mesh() {
    let film = Film::new(&["blur.teeth=1", "blur.toon.outline.strength=0"]);
    let size = film.shot.size;
    let Some(images) = film.images() else { return };
    let mut mesh = film.input(&film.settings);
    let desc = mesh.desc(size, film.shot.frames, 0, false, true);
    let of_mesh = film.output(desc, &mesh.frame(NUMBER).expect("a frame"), &images).expect("a device");
    let mut input = input(&film, all_passes(&film));
    let desc = input.desc(0, true).expect("a description");
    let frame = input.frame(NUMBER).expect("a frame");
    assert_eq!(frame.outer_images(), [Some(NUMBER - 2), Some(NUMBER + 1)]);
    let of_passes = film.output(desc.clone(), &frame, &images).expect("a device");
    see(&film, &[("mesh", &of_mesh), ("passes", &of_passes)]);
    let [a, b] = [&of_mesh[1], &of_passes[1]].map(|colours| contour(colours, size));
    let found = distances(&a, &b);
    let p95 = share(&found, 0.95);
    // What is asked for; half of all pixels of the outline are the same.
    assert!(a.len() > 1000 && share(&found, 0.5) == 0.0 && p95 <= 1.5, "{p95} of {}", a.len());
    let truth = film.drawn(&film.settings, NUMBER..=NUMBER).expect("a device");
    let [mesh_error, error] = colour_errors([&of_mesh, &of_passes], &truth[0], &images[2]);
    // What is asked for.
    assert!(error <= 2.0 * mesh_error, "{error} {mesh_error}");
    // Without strength there is no smear, and the picture is the image, bit for bit.
    let mut still = desc;
    still.settings.strength = 0.0;
    assert!(film.output(still, &frame, &images).expect("a device")[0] == images[2]);
}

/// Writes pictures into the folder that `CELFX_SEE` names, for whoever wants to look at them.
fn see(film: &Film, made: &[(&str, &[Picture; 2])]) {
    let Ok(folder) = std::env::var("CELFX_SEE") else { return };
    for (name, pictures) in made {
        for (what, picture) in ["picture", "colour"].iter().zip(*pictures) {
            let path = std::path::Path::new(&folder).join(format!("{name}_{what}.png"));
            write(&path, Format::Png, film.shot.size, picture, &Display::Srgb, None).expect("written");
        }
    }
}

/// Meshes of different sizes follow each other on one effect as if each were the first.
#[test]
fn each_output_has_a_mesh_of_its_own() {
    let film = Film::new(&["size=[160, 120]"]);
    let Some(images) = film.images() else { return };
    let mut input = input(&film, all_passes(&film));
    let desc = input.desc(0, true).expect("a description");
    let [earlier, later] = [NUMBER - 1, NUMBER].map(|number| input.frame(number).expect("a frame"));
    assert_ne!(earlier.mesh.points(), later.mesh.points());
    let alone = film.output(desc.clone(), &later, &images).expect("a device");
    let mut offline = common::device().expect("a device").offline(desc, Effort::Needed).expect("an effect");
    for frame in [&earlier, &later] {
        let image = |number: u32| Some(&images.get(number.checked_sub(NUMBER - 2)? as usize)?[..]);
        let [before, after] = frame.outer_images().map(|number| number.and_then(image));
        let blur = Some(BlurScene { frame, images: frame.images().map(image), outer: [before, after] });
        offline.frame(&Scene { blur, rendered: true, ..Scene::default() }).expect("rendered");
    }
    assert!(offline.picture() == alone[0]);
}

/// A disc flies behind a bar that stands still: its smear shows to both sides of that, and nowhere before it.
#[test]
fn a_smear_passes_behind_what_stands_still() {
    const SIZE: [u32; 2] = [160, 80];
    let shown = |number: u32, x: u32, y: u32| {
        let at = [x as f32 + 0.5, y as f32 + 0.5];
        let is_disc = (at[0] - (150.0 - 20.0 * number as f32)).hypot(at[1] - 40.0) < 14.0;
        match (104..112).contains(&x) {
            true => Some((2.0, 2, [0.0; 2], [0.0, 1.0, 0.0, 1.0])),
            false if is_disc => Some((3.0, 1, [20.0, 0.0], [1.0, 0.0, 0.0, 1.0])),
            false => None,
        }
    };
    let pixels = move |number: u32| {
        let nothing = (f32::INFINITY, 0, [0.0; 2], [0.0; 4]);
        let of = move |pixel: u32| shown(number, pixel % SIZE[0], pixel / SIZE[0]).unwrap_or(nothing);
        (0..SIZE[0] * SIZE[1]).map(of)
    };
    let read = move |number: u32| {
        let next = None;
        let (depth, id) = (pixels(number).map(|p| p.0).collect(), pixels(number).map(|p| p.1).collect());
        Ok(PassFrame { size: SIZE, depth, id, previous: pixels(number).map(|p| p.2).collect(), next })
    };
    let mut input = PassesInput::new(read, [1, 6], &Settings::default(), SIZE, 2).expect("settings");
    let frame = input.frame(3).expect("a frame");
    let Some(device) = common::device() else { return };
    let mut offline = device.offline(input.desc(0, false).expect("a description"), Effort::Needed).expect("an effect");
    let images: Vec<Picture> = (1..=4).map(|number| pixels(number).map(|p| p.3).collect()).collect();
    let image = |place: usize| Some(&images[place][..]);
    let blur = Some(BlurScene { frame: &frame, images: [image(1), image(2)], outer: [image(0), image(3)] });
    offline.frame(&Scene { blur, rendered: true, ..Scene::default() }).expect("rendered");
    let is_bar = |at: usize| (104..112).contains(&(at % SIZE[0] as usize));
    let is_smear = |at: &usize| offline.picture()[*at][0] > 0.5 && images[2][*at][0] == 0.0;
    for (at, pixel) in offline.picture().iter().enumerate().filter(|(at, _)| is_bar(*at)) {
        assert_eq!(*pixel, images[2][at], "{at}");
    }
    let smeared: Vec<usize> = (0..images[2].len()).filter(is_smear).map(|at| at % SIZE[0] as usize).collect();
    assert!(smeared.iter().any(|x| *x < 104) && smeared.iter().filter(|x| **x >= 112).count() > 20, "{smeared:?}");
}

/// The program makes the same of files: all passes as layers of one.
#[test]
fn files_of_a_renderer_become_smears() {
    let film = Film::new(&["size=[160, 120]"]);
    let Some(images) = film.images() else { return };
    let frames = all_passes(&film);
    let folder = std::env::temp_dir().join(format!("celfx-passes-{}", std::process::id()));
    for ((number, frame), image) in frames.iter().skip(1).zip(&images) {
        let mut channels: Vec<(String, Vec<f32>)> = Vec::new();
        let mut add = |name: &str, values: Vec<f32>| channels.push((format!("ViewLayer.{name}"), values));
        for (c, name) in ["R", "G", "B", "A"].iter().enumerate() {
            add(&format!("Combined.{name}"), image.iter().map(|pixel| pixel[c]).collect());
        }
        add("Depth.Z", frame.depth.iter().map(|z| z.min(1e10)).collect());
        add("IndexOB.X", frame.id.iter().map(|id| *id as f32).collect());
        let next = frame.next.as_ref().expect("both ways");
        for (vectors, names, by) in [(&frame.previous, ["X", "Y"], 1.0), (next, ["Z", "W"], -1.0)] {
            add(&format!("Vector.{}", names[0]), vectors.iter().map(|vector| by * vector[0]).collect());
            add(&format!("Vector.{}", names[1]), vectors.iter().map(|vector| -by * vector[1]).collect());
        }
        write_exr_channels(&folder.join(format!("{number:04}.exr")), film.shot.size, &channels).expect("written");
    }
    let keys = ["colour", "depth", "motion", "id"].map(|key| format!("{key} = \"####.exr\"\n")).concat();
    let shot = folder.join("shot.toml");
    let head = "size = [160, 120]\nframes = [1, 48]\nbackground = \"none\"\n";
    std::fs::write(&shot, format!("{head}[blur]\n[blur.passes]\n{keys}")).expect("written");
    let output = folder.join("out.####.exr");
    let mut celfx = std::process::Command::new(env!("CARGO_BIN_EXE_celfx"));
    celfx.arg("render").arg(&shot).args(["-q", "--frames", &NUMBER.to_string(), "--validate", "-o"]).arg(&output);
    celfx.args(["--motion", "--layers"]).arg(folder.join("one.####.exr"));
    let run = celfx.output().expect("the program");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let made = read(&folder.join(format!("out.{NUMBER:04}.exr"))).expect("a picture").pixels;
    let mut input = input(&film, frames);
    let desc = input.desc(0, true).expect("a description");
    let expected = film.output(desc, &input.frame(NUMBER).expect("a frame"), &images).expect("a device");
    assert!(made == expected[0]);
    std::fs::remove_dir_all(&folder).expect("removed");
}
