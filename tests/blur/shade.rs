//! What is drawn: which triangle a pixel sees, against f64, and the colours that it gets from both frames.

use celfx::blur::motion::{Motion, Window};
use celfx::blur::settings::{Completion, Mix};
use celfx::blur::{Interval, Mesh, Settings};
use celfx::low_level::blur::layout;
use celfx::low_level::blur::params::{BASE_MASK, Vertex};
use glam::{DVec2, DVec3};

use crate::common::blur::{BlurRig, Shot, desc};
use crate::common::views;
use crate::scenes::{Animation, Change, grid, swing};

const SIDES: [u32; 2] = [9, 7];
const SIZE: [u32; 2] = [160, 120];
const I: usize = 3;
/// Pixels this near to an edge may be seen either way: rasterisers have 8 bits below the pixel.
const NEAR: f64 = 1.0 / 64.0;

/// A camera's, and others that see as much.
const VIEWS: [Change; 4] = [
    |view, _| view,
    |view, frame| views::jittered(views::moved(view), frame),
    |view, frame| views::jittered(views::mirrored(views::squeezed(view)), frame),
    |view, frame| views::jittered(views::parallel_around(view, 4.0, 3.0), frame),
];

/// Pixels and view depth.
type Corner = DVec3;

fn cross(a: DVec2, b: DVec2) -> f64 {
    a.perp_dot(b)
}

/// Shares of the corners in what is seen at a place, as perspective has it; none outside. The second: whether the place is
/// near an edge.
fn within(is_parallel: bool, corners: &[Corner; 3], at: DVec2) -> (Option<[f64; 3]>, bool) {
    let [a, b, c] = corners.map(|corner| corner.truncate() - at);
    let parts = [cross(b, c), cross(c, a), cross(a, b)];
    let area: f64 = parts.iter().sum();
    let lengths = [(c - b).length(), (a - c).length(), (b - a).length()];
    let distances = [0, 1, 2].map(|i| parts[i] / area * area.abs() / lengths[i].max(1e-9));
    let nearest = distances.into_iter().fold(f64::INFINITY, f64::min);
    let weights = [0, 1, 2].map(|i| parts[i] / if is_parallel { 1.0 } else { corners[i].z });
    let sum: f64 = weights.iter().sum();
    let shares = weights.map(|w| w / sum);
    ((nearest > 0.0).then_some(shares), nearest.abs() < NEAR)
}

/// The nearest triangle at a pixel, from 1; none where rounding may decide.
fn name(is_parallel: bool, triangles: &[[Corner; 3]], at: DVec2) -> Option<u32> {
    let mut found: (u32, f64) = (0, f64::INFINITY);
    let mut second = f64::INFINITY;
    for (index, corners) in (1..).zip(triangles) {
        let (shares, is_near) = within(is_parallel, corners, at);
        if is_near {
            return None;
        }
        if let Some(shares) = shares {
            let depth: f64 = shares.iter().zip(corners).map(|(share, corner)| share * corner.z).sum();
            if depth < found.1 {
                second = found.1;
                found = (index, depth);
            } else {
                second = second.min(depth);
            }
        }
    }
    (second - found.1 > 1e-5 * found.1 || found.0 == 0).then_some(found.0)
}

fn centre(pixel: usize) -> DVec2 {
    let (x, y) = (pixel as u32 % SIZE[0], pixel as u32 / SIZE[0]);
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

struct Scene {
    mesh: Mesh,
    animation: Animation,
    interval: Interval,
    rig: BlurRig,
}

impl Scene {
    fn new(settings: Settings) -> Option<Scene> {
        Scene::through(settings, |view, _| view)
    }

    /// One whose frames are seen through other views.
    fn through(settings: Settings, change: Change) -> Option<Scene> {
        let (mesh, animation) = (grid(SIDES), Animation { change, ..swing(SIDES, 8, SIZE, 0.3) });
        let seen = animation.all_seen();
        let window = Window { frame: I as u32, poses: &animation.poses(&seen), current: I, between: &[] };
        let motion = Motion::new(&settings, SIZE).expect("settings");
        let interval = motion.interval(&mesh, &window, 1).expect("an interval");
        let rig = BlurRig::new(desc(SIZE, &mesh, settings), mesh.clone())?;
        Some(Scene { mesh, animation, interval, rig })
    }

    fn render(&mut self, is_first: bool) {
        let poses = is_first.then_some((0, &self.animation.poses[..]));
        let views = self.animation.views(I);
        let shot = Shot { poses, interval: Some(&self.interval), views, knots: None };
        self.rig.frame(&shot).expect("a frame");
    }

    /// The mesh in a frame.
    fn seen(&self, frame: usize) -> Vec<[Corner; 3]> {
        let corner = |point: u32| self.animation.pixel(frame, point as usize);
        self.mesh.triangles().iter().map(|t| t.map(corner)).collect()
    }

    /// Where a vertex of the grid is on it.
    fn surface(&self, point: u32) -> DVec2 {
        let side = |at: u32, sides: u32| f64::from(at) / f64::from(sides - 1);
        DVec2::new(side(point % SIDES[0], SIDES[0]), side(point / SIDES[0], SIDES[1]))
    }

    /// The place on the grid of shares of a triangle's corners.
    fn place(&self, base: u32, shares: [f64; 3]) -> DVec2 {
        let corners = self.mesh.triangles()[base as usize];
        shares.iter().zip(corners).map(|(share, point)| *share * self.surface(point)).sum()
    }

    /// A frame whose colours are places on the grid: red and green, over blue.
    fn picture(&self, frame: usize, blue: f32) -> Vec<[f32; 4]> {
        let (triangles, is_parallel) = (self.seen(frame), self.animation.is_parallel());
        let pixel = |pixel: usize| {
            let found = (0..).zip(&triangles).filter_map(|(base, corners)| {
                let shares = within(is_parallel, corners, centre(pixel)).0?;
                let depth: f64 = shares.iter().zip(corners).map(|(share, corner)| share * corner.z).sum();
                Some((depth, self.place(base, shares)))
            });
            match found.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((_, place)) => [place.x as f32, place.y as f32, blue, 1.0],
                None => [0.1, 0.2, 0.3 + blue, 1.0],
            }
        };
        (0..(SIZE[0] * SIZE[1]) as usize).map(pixel).collect()
    }
}

/// How many pixels are looked at, and how many of them see another triangle.
fn differences(is_parallel: bool, names: &[u32], triangles: &[[Corner; 3]]) -> (usize, usize) {
    let looked = (0..names.len()).filter_map(|pixel| Some((pixel, name(is_parallel, triangles, centre(pixel))?)));
    looked.fold((0, 0), |(all, wrong), (pixel, expected)| (all + 1, wrong + usize::from(names[pixel] != expected)))
}

#[test]
fn pixels_see_the_triangles_that_f64_sees() {
    for change in VIEWS {
        let Some(scene) = Scene::through(Settings::default(), change) else { return };
        pixels_see_triangles(scene);
    }
}

fn pixels_see_triangles(mut scene: Scene) {
    let is_parallel = scene.animation.is_parallel();
    scene.render(true);
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    for (frame, layer) in [(I, layout::PREVIOUS_NAMES), (I + 1, layout::NEXT_NAMES)] {
        let (all, wrong) = differences(is_parallel, &scene.rig.layer(layer), &scene.seen(frame));
        assert!(all > pixels * 9 / 10 && wrong == 0, "frame {frame}: {wrong} of {all}");
    }
    let (vertices, finished) = (scene.rig.vertices(), scene.rig.finished());
    let corner = |v: &u32| drawn(&vertices[*v as usize]);
    let triangles: Vec<[Corner; 3]> = finished.iter().map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])]).collect();
    let names: Vec<u32> = scene.rig.layer(layout::DISTORTED_NAMES);
    let (all, wrong) = differences(is_parallel, &names, &triangles);
    let covered = names.iter().filter(|name| **name > 0).count();
    eprintln!("{} triangles over {covered} pixels", triangles.len());
    assert!(all > pixels * 8 / 10 && covered > pixels / 15 && wrong == 0, "distorted: {wrong} of {all}");
}

/// Pixels and view depth of where a vertex is drawn.
fn drawn(vertex: &Vertex) -> DVec3 {
    DVec3::new(vertex.drawn[0].into(), vertex.drawn[1].into(), vertex.drawn_depth.into())
}

/// Colours that are places on the surface come from the same place in both frames.
#[test]
fn colours_are_those_of_the_surface() {
    for change in VIEWS {
        let Some(scene) = Scene::through(Settings::default(), change) else { return };
        colours_are_of_the_surface(scene);
    }
}

fn colours_are_of_the_surface(mut scene: Scene) {
    let is_parallel = scene.animation.is_parallel();
    let images = [scene.picture(I, 0.0), scene.picture(I + 1, 0.5)];
    scene.rig.set_image(0, &images[0]);
    scene.rig.set_image(1, &images[1]);
    scene.render(true);
    let (vertices, finished) = (scene.rig.vertices(), scene.rig.finished());
    let names: Vec<u32> = scene.rig.layer(layout::DISTORTED_NAMES);
    let masks: Vec<u32> = scene.rig.layer(layout::MASK_LAYER);
    let times: Vec<f32> = scene.rig.layer(layout::SUBFRAME_LAYER);
    let colours: [Vec<[f32; 4]>; 2] = [layout::PREVIOUS_LAYER, layout::NEXT_LAYER].map(|id| scene.rig.layer(id));
    let picture = scene.rig.picture();
    let (mut errors, mut both) = (Vec::new(), 0);
    for pixel in 0..names.len() {
        if names[pixel] == 0 {
            assert_eq!(masks[pixel], 4);
            continue;
        }
        let triangle = finished[names[pixel] as usize - 1];
        let corners = [0, 1, 2].map(|i| vertices[triangle[i] as usize]);
        let drawn = corners.map(|v| drawn(&v));
        let (Some(shares), false) = within(is_parallel, &drawn, centre(pixel)) else { continue };
        let base = triangle[3] & BASE_MASK;
        let places = [0, 1, 2].map(|i| match corners[i].is_point() {
            true => scene.surface(triangle[i]),
            false => {
                let [v, w] = corners[i].barycentrics.map(f64::from);
                scene.place(base, [1.0 - v - w, v, w])
            }
        });
        let place: DVec2 = shares.iter().zip(places).map(|(share, place)| *share * place).sum();
        let time: f64 = shares.iter().zip(corners).map(|(share, v)| share * f64::from(v.drawn_time)).sum();
        assert!((f64::from(times[pixel]) - time).abs() < 1e-3, "pixel {pixel}: {} is not {time}", times[pixel]);
        if corners.iter().all(|v| v.drawn_time == 1.0) {
            continue;
        }
        for (bit, colours) in [1, 2].into_iter().zip(&colours) {
            if masks[pixel] & bit != 0 {
                let off = (DVec2::new(colours[pixel][0].into(), colours[pixel][1].into()) - place).length();
                errors.push(off);
            }
        }
        both += u32::from(masks[pixel] == 3);
    }
    errors.sort_by(f64::total_cmp);
    let (looked, usual, worst) = (errors.len(), errors[errors.len() * 9 / 10], errors[errors.len() - 1]);
    eprintln!("{looked} look-ups, {both} pixels see both, {usual:.1e} off, at most {worst:.1e}");
    // A pixel is 1/40 of the grid, or 1/28 where it is wider. At an outline, look-ups have taps to one side only: they are up to a pixel off.
    assert!(looked > 1000 && both > 300 && usual < 2e-3 && worst < 1.0 / 28.0, "{looked}, {both}: {usual}, {worst}");
    let outside = (0..names.len()).filter(|p| names[*p] == 0 && picture[*p] == images[1][*p]).count();
    assert!(outside > names.len() / 3, "what nothing covers is frame i + 1: {outside}");
    assert!(picture.as_flattened().iter().all(|c| c.is_finite()));
}

/// Where all is one colour, the mixture is k' of it.
#[test]
fn frames_are_mixed_by_time() {
    // What one frame hides is as the other one shows it, and not what light would make of it.
    let settings = Settings { completion: Completion::None, mix: Mix::Blend, ..Settings::default() };
    let Some(mut scene) = Scene::new(settings) else { return };
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let (red, green) = ([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]);
    scene.rig.set_image(0, &vec![red; pixels]);
    scene.rig.set_image(1, &vec![green; pixels]);
    scene.render(true);
    let (picture, layer) = (scene.rig.picture(), scene.rig.layer::<[f32; 4]>(layout::COLOUR_LAYER));
    let masks: Vec<u32> = scene.rig.layer(layout::MASK_LAYER);
    let mut mixed = 0;
    for pixel in 0..pixels {
        let [r, g, b, a] = picture[pixel];
        // Where both frames have only the mesh, nothing is behind it.
        assert!(b == 0.0 && (r + g - a).abs() < 1e-5 && a <= 1.00001, "{:?}", picture[pixel]);
        assert!(layer[pixel][3] <= 1.0 + 1e-5);
        mixed += usize::from(masks[pixel] == 3 && r > 0.02 && g > 0.02);
    }
    assert!(mixed > 100, "{mixed}");
}

#[test]
fn no_strength_and_no_motion_are_the_later_image() {
    let image: Vec<[f32; 4]> =
        (0..SIZE[0] * SIZE[1]).map(|i| [0, 1, 2, 3].map(|c| crate::common::scenes::random(3, i, c))).collect();
    for strength in [0.0, 1.0] {
        let Some(mut scene) = Scene::new(Settings { strength, ..Settings::default() }) else { return };
        scene.rig.set_image(1, &image);
        if strength > 0.0 {
            let views = scene.animation.views(I);
            let shot = Shot { poses: None, interval: None, views, knots: None };
            scene.rig.frame(&shot).expect("a frame");
        } else {
            scene.render(true);
        }
        assert!(scene.rig.picture() == image, "strength {strength}: to the bit");
        assert_eq!(scene.rig.steps().last(), Some(if strength > 0.0 { &"blur.mesh" } else { &"blur.poses" }));
    }
}

/// Leaving frames out, and drawing them again, changes nothing.
#[test]
fn a_frame_depends_on_no_other() {
    let Some(mut scene) = Scene::new(Settings::default()) else { return };
    let images = [scene.picture(I, 0.0), scene.picture(I + 1, 0.5)];
    scene.rig.set_image(0, &images[0]);
    scene.rig.set_image(1, &images[1]);
    scene.render(true);
    let first = scene.rig.picture();
    scene.render(false);
    assert!(scene.rig.picture() == first);
}

/// Pixels at the mesh's border are covered in part, and have so much less alpha; the surface has not.
#[test]
fn borders_are_as_opaque_as_the_surface() {
    let settings = Settings { completion: Completion::None, skirt: 0.0, ..Settings::default() };
    let Some(mut scene) = Scene::new(settings) else { return };
    scene.render(true);
    let width = SIZE[0] as usize;
    for (frame, id) in [layout::PREVIOUS_NAMES, layout::NEXT_NAMES].into_iter().enumerate() {
        let names: Vec<u32> = scene.rig.layer(id);
        let beside = [0, 1, 2, width, width + 2, 2 * width, 2 * width + 1, 2 * width + 2];
        let is_border =
            |pixel: usize| beside.iter().any(|way| names.get((pixel + way).wrapping_sub(width + 1)) == Some(&0));
        let pixel = |pixel: usize| match (names[pixel], is_border(pixel)) {
            (0, _) => [0.0; 4],
            (_, true) => [0.25, 0.0, 0.0, 0.25],
            (_, false) => [1.0, 0.0, 0.0, 1.0],
        };
        scene.rig.set_image(frame, &(0..names.len()).map(pixel).collect::<Vec<_>>());
    }
    scene.render(false);
    let masks: Vec<u32> = scene.rig.layer(layout::MASK_LAYER);
    for (bit, id) in [(1, layout::PREVIOUS_LAYER), (2, layout::NEXT_LAYER)] {
        let colours: Vec<[f32; 4]> = scene.rig.layer(id);
        let known: Vec<&[f32; 4]> =
            colours.iter().zip(&masks).filter(|(_, mask)| *mask & bit != 0).map(|(c, _)| c).collect();
        assert!(known.len() > 500, "{}", known.len());
        // What rounding leaves of four shares.
        assert!(known.iter().all(|c| (c[3] - 1.0).abs() < 1e-5 && (c[0] - 1.0).abs() < 1e-5));
    }
}
