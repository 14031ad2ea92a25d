use std::sync::OnceLock;

use glam::{DVec3, Vec3};

use super::*;
use crate::blur::mesh::MeshInput;
use crate::blur::motion::{Interval, Motion, PixelClip, Pose, Window};
use crate::blur::reference::complete::complete;
use crate::blur::reference::distort::{Drawing, draw, hidden};
use crate::blur::reference::extent::extents;
use crate::blur::reference::refine::{Rules, refine};
use crate::blur::reference::visible::{Colour, Frame, Surface, compose, mix, shade};
use crate::blur::settings::{Completion, Mix, Settings};
use crate::view::Camera;

const SIZE: [u32; 2] = [240, 160];
const CURRENT: usize = 5;
/// How far the first sphere turns from frame to frame, in radians.
const SLOWLY: f32 = 0.15;
const FAST: f32 = 0.5;

/// Spheres of 16 x 32 quadrilaterals: one turns and moves a little, one goes past in front, one far off to the side stays.
const SPHERES: usize = 3;

fn camera() -> Camera {
    Camera { eye: DVec3::new(0.0, 0.0, 6.0), target: DVec3::ZERO, ..Camera::default() }
}

fn placed(turn: f32, sphere: usize, frame: usize, p: Vec3) -> [f32; 3] {
    let t = frame as f32 - CURRENT as f32;
    let turned =
        |angle: f32| Vec3::new(p.x * angle.cos() + p.z * angle.sin(), p.y, p.z * angle.cos() - p.x * angle.sin());
    let place = match sphere {
        0 => turned(turn * t) + Vec3::new(0.1 * t, 0.05 * t, 0.0),
        1 => turned(0.1 * t) * 0.5 + Vec3::new(0.7 * t - 0.3, 0.1, 2.0),
        _ => p * 0.6 + Vec3::new(2.2, 1.2, -0.5),
    };
    place.to_array()
}

fn mesh() -> (Mesh, Vec<Vec3>) {
    let (rows, columns) = (16_u32, 32_u32);
    let mut points = vec![Vec3::Y, -Vec3::Y];
    for (row, column) in (1..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let polar = row as f32 / rows as f32 * std::f32::consts::PI;
        let around = column as f32 / columns as f32 * std::f32::consts::TAU;
        points.push(Vec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin()));
    }
    let at = |row: u32, column: u32| match row {
        0 => 0,
        _ if row == rows => 1,
        _ => 2 + (row - 1) * columns + column % columns,
    };
    let mut sphere: Vec<[u32; 3]> = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let [a, b] = [at(row, column), at(row, column + 1)];
        let [c, d] = [at(row + 1, column + 1), at(row + 1, column)];
        sphere.extend([[a, b, c], [a, c, d]]);
    }
    sphere.retain(|[a, b, c]| a != b && b != c && c != a);
    let count = points.len();
    let triangles: Vec<[u32; 3]> =
        (0..SPHERES).flat_map(|s| sphere.iter().map(move |t| t.map(|p| p + (s * count) as u32))).collect();
    let objects: Vec<u32> = (0..SPHERES as u32).flat_map(|s| vec![s; count]).collect();
    let vertices = SPHERES * count;
    let input =
        MeshInput { vertices, triangles: &triangles, objects: Some(&objects), weld: None, normals: None, rest: None };
    (Mesh::new(&input).unwrap(), points)
}

/// The colour of a surface if nothing hides it: two tones, or three stripes of each.
fn look(object: u32, normal: [f64; 3], rest: DVec3, striped: bool) -> Colour {
    let light = DVec3::from_array(normal).normalize_or_zero().dot(DVec3::new(0.4, 0.7, 0.6));
    let tone = if light > 0.3 { [0.8, 0.35, 0.25] } else { [0.3, 0.1, 0.2] };
    let stripe = if striped && (rest.y * 6.0).rem_euclid(2.0) < 1.0 { 0.4 } else { 1.0 };
    let turned = if object == 1 { [tone[2], tone[0], tone[1]] } else { tone };
    [turned[0] * stripe, turned[1] * stripe, turned[2] * stripe, 1.0]
}

struct Scene {
    mesh: Mesh,
    points: Vec<Vec3>,
    interval: Interval,
    corners: [Vec<[Clip; 3]>; 2],
    normals: [Vec<[[f64; 3]; 3]>; 2],
    outsides: [Vec<Outside>; 2],
    closed: Vec<bool>,
    still: Vec<bool>,
    /// The distorted mesh, once something is drawn of it: refining takes longest.
    triangles: OnceLock<Vec<Triangle>>,
}

/// The scene that turns slowly. Several tests look at it.
fn slow() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| Scene::new(SLOWLY))
}

impl Scene {
    fn new(turn: f32) -> Scene {
        let (mesh, points) = mesh();
        let (view, settings) = (camera().view(SIZE), Settings::default());
        let pose = |frame: usize| -> Vec<[f32; 3]> {
            (0..SPHERES).flat_map(|s| points.iter().map(move |p| placed(turn, s, frame, *p))).collect()
        };
        let poses: Vec<Vec<[f32; 3]>> = (0..12).map(pose).collect();
        let views: Vec<Pose> = poses.iter().map(|p| Pose { positions: p, view: &view, cut: false }).collect();
        let window = Window { frame: CURRENT as u32, poses: &views, current: CURRENT, between: &[] };
        let interval = Motion::new(&settings, SIZE).unwrap().interval(&mesh, &window, 1).unwrap();
        let both = [&poses[CURRENT], &poses[CURRENT + 1]];
        let corners = both.map(|positions| corners(&mesh, positions, &view, SIZE));
        let outsides = both.map(|positions| outsides(&mesh, positions, &view, SIZE));
        let normals = [0, 1].map(|k| normals(&mesh, both[k], &outsides[k]));
        let (closed, still) = (closed([&outsides[0], &outsides[1]]), still(&mesh, &interval.labels));
        let triangles = OnceLock::new();
        Scene { mesh, points, interval, corners, normals, outsides, closed, still, triangles }
    }

    fn surface(&self) -> Surface<'_> {
        Surface {
            surfaces: self.mesh.triangle_surfaces(),
            closed: &self.closed,
            still: &self.still,
            near: camera().near,
        }
    }

    fn triangles(&self) -> &[Triangle] {
        self.triangles.get_or_init(|| {
            let settings = Settings::default();
            let rules = Rules { interval: &self.interval, settings: &settings, size: SIZE, seed: 3, budget: 1_000_000 };
            let extents = extents(&self.mesh, &rules.pull(), &[]);
            triangles(&refine(&self.mesh, &extents, &rules), &self.interval.segments, false)
        })
    }

    fn draw(&self, samples: u32, culls: bool) -> Drawing {
        let hidden = match culls {
            true => hidden(self.corners.each_ref().map(|c| &c[..]), self.outsides.each_ref().map(|o| &o[..])),
            false => vec![false; self.closed.len()],
        };
        draw(self.triangles(), &hidden, SIZE, camera().near, samples)
    }

    /// The true colour of a place in a frame.
    fn truth(&self, frame: &Frame, base: u32, weights: [f64; 3], striped: bool) -> Colour {
        let points = self.mesh.triangles()[base as usize];
        let rest = points.map(|p| self.points[p as usize % self.points.len()].as_dvec3());
        let rest = rest[0] * weights[0] + rest[1] * weights[1] + rest[2] * weights[2];
        let object = self.mesh.triangle_objects()[base as usize];
        look(object, frame.normal(&self.surface(), base, weights), rest, striped)
    }

    fn images(&self, striped: bool) -> [Vec<[f32; 4]>; 2] {
        [0, 1].map(|k| {
            let frame = Frame::new(&self.corners[k], &self.normals[k], &[], SIZE, camera().near);
            let colour = |pixel: usize| match frame.place(pixel) {
                Some((base, weights)) => self.truth(&frame, base, weights, striped).map(|c| c as f32),
                None => [0.1, 0.2, 0.4, 1.0],
            };
            (0..frame.seen.seen.len()).map(colour).collect()
        })
    }
}

#[test]
fn corners_are_where_the_camera_sees_them_and_normals_point_outward() {
    let scene = slow();
    let projection = PixelClip::new(&camera().view(SIZE), [0.0; 2], SIZE);
    for (triangle, points) in scene.mesh.triangles().iter().enumerate() {
        for (i, point) in points.iter().enumerate() {
            let (sphere, p) =
                (*point as usize / scene.points.len(), scene.points[*point as usize % scene.points.len()]);
            let expected = projection.clip(placed(SLOWLY, sphere, CURRENT, p));
            assert!((expected - DVec3::from_array(scene.corners[0][triangle][i])).length() < 1e-9);
            let normal = DVec3::from_array(scene.normals[0][triangle][i]).normalize();
            assert!(sphere > 0 || normal.dot(p.as_dvec3()) > 0.97, "{normal} {p}");
        }
    }
    assert!(scene.closed.iter().all(|closed| *closed));
    let third = scene.still.len() / 3;
    assert!(scene.still.iter().enumerate().all(|(i, still)| *still == (i >= 2 * third)));
}

#[test]
fn what_is_turned_away_in_both_frames_is_hardly_ever_seen() {
    let scene = slow();
    let [all, culled] = [false, true].map(|culls| scene.draw(1, culls));
    let seen = all.raster.seen.iter().filter(|name| **name > 0).count();
    let differ = all.raster.seen.iter().zip(&culled.raster.seen).filter(|(a, b)| a != b).count();
    assert!(seen > 5000 && 100 * differ < seen, "{differ} of {seen}");
}

/// Mean errors of the colours of samples that one frame shows, one of each way, and the number of samples.
fn errors(scene: &Scene, drawing: &Drawing, striped: bool, ways: [Completion; 3]) -> ([f64; 3], usize) {
    let images = scene.images(striped);
    let frames = [0, 1].map(|k| Frame::new(&scene.corners[k], &scene.normals[k], &images[k], SIZE, camera().near));
    let frames = [&frames[0], &frames[1]];
    let surface = scene.surface();
    let shaded = shade(&surface, drawing, frames, [None; 2]);
    let colours = ways.map(|how| complete(&surface, drawing, frames, &shaded, how, Mix::Blend));
    let (mut sums, mut count) = ([0.0; 3], 0);
    for (place, sample) in shaded.iter().enumerate().filter(|(_, sample)| [1, 2].contains(&sample.mask)) {
        let Some(fragment) = sample.fragment.filter(|f| !scene.still[f.base as usize]) else { continue };
        let sides = frames.map(|frame| scene.truth(frame, fragment.base, fragment.weights, striped));
        let expected = mix(fragment.time, sides);
        for (sum, colours) in sums.iter_mut().zip(&colours) {
            *sum += (0..3).map(|i| (colours[place][i] - expected[i]).abs()).sum::<f64>() / 3.0;
        }
        count += 1;
    }
    (sums.map(|sum| sum / count as f64), count)
}

#[test]
fn the_surface_predicts_better_than_the_other_side_and_the_gradient() {
    // Sums of a thousand numbers may be rounded otherwise. Both spheres that move have shadows of their own colour, so that
    // little of a tone is common to all.
    let fast = Scene::new(FAST);
    for (turn, scene, most) in [(SLOWLY, slow(), [1.0, 1.0]), (FAST, &fast, [0.8, 1.0])] {
        let drawing = scene.draw(1, true);
        for (striped, most) in [false, true].into_iter().zip(most) {
            let ways = [Completion::Surface, Completion::Gradient, Completion::None];
            let ([surface, gradient, none], count) = errors(scene, &drawing, striped, ways);
            assert!(
                count > 300 && surface <= most * none * (1.0 + 1e-12) && surface < gradient,
                "{turn}, {striped}: {surface}, {gradient}, {none} of {count}"
            );
        }
    }
}

#[test]
fn the_sphere_that_stays_is_the_next_image() {
    let scene = slow();
    let images = scene.images(true);
    let frames = [0, 1].map(|k| Frame::new(&scene.corners[k], &scene.normals[k], &images[k], SIZE, camera().near));
    let frames = [&frames[0], &frames[1]];
    let (surface, drawing) = (scene.surface(), scene.draw(2, true));
    let shaded = shade(&surface, &drawing, frames, [None; 2]);
    let colours = complete(&surface, &drawing, frames, &shaded, Completion::Surface, Mix::Blend);
    let image = compose(&surface, &drawing, frames, &shaded, &colours, [0.0; 4]);
    let is_same = |pixel: &usize| image[*pixel] == images[1][*pixel].map(f64::from);
    let shown =
        |frame: &Frame, pixel: usize| frame.seen.seen[pixel].checked_sub(1).map(|base| surface.surfaces[base as usize]);
    let own: Vec<usize> = (0..images[1].len()).filter(|pixel| shown(frames[1], *pixel) == Some(2)).collect();
    assert!(own.len() > 300 && own.iter().all(is_same), "{}", own.len());
    assert!((0..images[1].len()).filter(|pixel| !is_same(pixel)).count() > 1000);
}
