//! The host's depth: it hides the mesh where it is nearer, takes the mesh's, and changes nothing else.

use ash::vk;
use celfx::blur::motion::{Motion, Window};
use celfx::blur::reference::raster::{Clip, Raster, Shape, raster};
use celfx::blur::settings::{Ghosts, Lines};
use celfx::blur::{Background, DepthFormat, Desc, Interval, Mesh, MeshInput, Settings};
use celfx::low_level::blur::layout;
use celfx::low_level::blur::params::{BASE_MASK, Vertex};
use celfx::view::{Camera, Light, Projection};

use crate::common::blur::{BESIDE, BlurRig, Shot, desc, incomplete};
use crate::common::scenes::random;
use crate::common::views;
use crate::scenes::{Animation, grid, swing};

const SIDES: [u32; 2] = [9, 7];
const SIZE: [u32; 2] = [160, 120];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
const I: usize = 3;

/// How depth is held: reversed or not, and the far plane. The near plane is the cameras'.
const CONVENTIONS: [(bool, f32); 3] = [(false, 50.0), (true, 50.0), (true, f32::INFINITY)];

struct Scene {
    animation: Animation,
    interval: Interval,
    rig: BlurRig,
}

impl Scene {
    /// `depth`: how the host holds depth, if it does.
    fn new(settings: Settings, depth: Option<(bool, f32)>, toon: bool) -> Option<Scene> {
        Scene::in_larger_images(settings, depth, toon, [0; 2])
    }

    /// One whose pictures begin so far from the upper left of their images.
    fn in_larger_images(settings: Settings, depth: Option<(bool, f32)>, toon: bool, corner: [u32; 2]) -> Option<Scene> {
        Scene::of(grid(SIDES), settings, depth, toon, corner)
    }

    /// Of a mesh of as many vertices as that grid has.
    fn of(mesh: Mesh, settings: Settings, depth: Option<(bool, f32)>, toon: bool, corner: [u32; 2]) -> Option<Scene> {
        let mut animation = swing(SIDES, 8, SIZE, 0.3);
        let seen = animation.all_seen();
        let window = Window { frame: I as u32, poses: &animation.poses(&seen), current: I, between: &[] };
        let motion = Motion::new(&settings, SIZE).expect("settings");
        let interval = motion.interval(&mesh, &window, 1).expect("an interval");
        let format = depth.map(|(reversed, _)| DepthFormat { format: vk::Format::D32_SFLOAT, reversed });
        let desc = Desc { depth: format, toon, ..desc(SIZE, &mesh, settings) };
        let mut rig = BlurRig::in_larger_images(desc, mesh, corner)?;
        rig.toon = toon.then(|| (Light::default(), Background::Clear([0.25, 0.5, 0.75, 1.0])));
        if let Some((reversed, far)) = depth {
            animation.cameras.iter_mut().for_each(|camera| camera.far = far.into());
            animation.change = if reversed { |view, _| view } else { |view, _| view.with_reversed(false) };
            rig.wall = if reversed { 0.0 } else { 1.0 };
        }
        let mut scene = Scene { animation, interval, rig };
        scene.set_images(1.0);
        Some(scene)
    }

    /// Terms of the host's depth, as the kernels have them.
    fn terms(&self) -> [f64; 2] {
        Projection::of_valid(&self.animation.seen(I + 1), SIZE).depth_terms.map(|term| f64::from(term as f32))
    }

    /// Images of noise, of this least alpha.
    fn set_images(&mut self, least: f32) {
        for frame in 0..2 {
            let pixel = |i: u32| {
                let alpha = least + (1.0 - least) * random(7, i, 3);
                [0, 1, 2, 3].map(|c| if c == 3 { alpha } else { alpha * random(frame, i, c) })
            };
            self.rig.set_image(frame as usize, &(0..PIXELS as u32).map(pixel).collect::<Vec<_>>());
        }
    }

    fn render(&mut self, is_first: bool, moves: bool) {
        let poses = is_first.then_some((0, &self.animation.poses[..]));
        let views = self.animation.views(I);
        let interval = moves.then_some(&self.interval);
        self.rig.frame(&Shot { poses, interval, views, knots: None }).expect("a frame");
    }

    /// The mesh of a frame at four samples a pixel.
    fn seen(&self, frame: usize) -> Samples {
        let points = self.animation.poses[frame].len();
        let clips: Vec<Clip> = (0..points).map(|point| self.animation.clip(frame, point).to_array()).collect();
        let corners = self.rig.mesh.triangles().iter().map(|t| t.map(|point| clips[point as usize]));
        Samples::new(corners.collect(), self.animation.cameras[I].near)
    }

    /// The distorted mesh of the last frame at four samples a pixel.
    fn distorted(&mut self) -> Samples {
        let (vertices, finished) = (self.rig.vertices(), self.rig.finished());
        let corner = |vertex: u32| {
            let Vertex { drawn: [x, y], drawn_depth, .. } = vertices[vertex as usize];
            let [x, y, w] = [x, y, drawn_depth].map(f64::from);
            [x * w, y * w, w]
        };
        let corners = finished.iter().map(|t| [corner(t[0]), corner(t[1]), corner(t[2])]);
        Samples::new(corners.collect(), self.animation.cameras[I].near)
    }
}

/// What f64 sees at four samples a pixel.
struct Samples {
    shapes: Vec<Option<Shape>>,
    raster: Raster,
}

impl Samples {
    fn new(corners: Vec<[Clip; 3]>, near: f64) -> Samples {
        let shape = |corners: [Clip; 3]| Shape::new(corners.map(|[x, y, w]| [2.0 * x, 2.0 * y, w]));
        let shapes: Vec<Option<Shape>> = corners.into_iter().map(shape).collect();
        let raster = raster(&shapes, SIZE.map(|side| 2 * side), near);
        Samples { shapes, raster }
    }

    /// 1 / W of the farthest of a pixel's samples, and how far off a device may be; 0 where one of them sees nothing. None
    /// where rounding decides.
    fn farthest(&self, pixel: usize) -> Option<(f64, f64)> {
        let width = SIZE[0] as usize;
        let (x, y) = (2 * (pixel % width), 2 * (pixel / width));
        let at = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (y + dy) * 2 * width + x + dx);
        if at.iter().any(|at| self.raster.uncertain[*at]) {
            return None;
        }
        let seen = at.map(|at| self.raster.seen[at]);
        if seen.contains(&0) {
            return Some((0.0, 0.0));
        }
        let depth = at.iter().map(|at| self.raster.depth[*at]).fold(0.0, f64::max);
        let slopes = seen.iter().filter_map(|name| self.shapes[*name as usize - 1].as_ref()).map(Shape::slope);
        // Corners are snapped to 1/256 of a sample, which moves what is interpolated as far; and it is so in f32.
        Some((1.0 / depth, slopes.fold(0.0, f64::max) / 128.0 + 4e-6 / depth))
    }
}

/// Compares the host's depth with that of samples; how many pixels are the mesh's.
fn compare(found: &[f32], samples: &Samples, rig: &BlurRig, terms: [f64; 2], what: &str) -> usize {
    let [offset, scale] = terms;
    let (mut compared, mut of_mesh) = (0, 0);
    for (pixel, stored) in found.iter().enumerate() {
        let Some((inverse, slack)) = samples.farthest(pixel) else { continue };
        compared += 1;
        if inverse == 0.0 {
            assert_eq!(*stored, rig.wall, "{what}, pixel {pixel}: nothing is there, or an edge");
            continue;
        }
        of_mesh += 1;
        let (off, bound) = (f64::from(*stored) - offset - scale * inverse, scale.abs() * slack + 2e-7);
        assert!(off.abs() <= bound, "{what}, pixel {pixel}: {off:e} off, at most {bound:e} expected");
    }
    assert!(compared > PIXELS * 7 / 10, "{what}: {compared} of {PIXELS}");
    of_mesh
}

#[test]
fn the_hosts_depth_takes_that_of_the_distorted_mesh() {
    for convention in CONVENTIONS {
        let settings = Settings { skirt: 0.0, ..incomplete() };
        let Some(mut scene) = Scene::new(settings, Some(convention), false) else { return };
        scene.render(true, true);
        let (found, samples) = (scene.rig.host_depths(), scene.distorted());
        let of_mesh = compare(&found, &samples, &scene.rig, scene.terms(), &format!("{convention:?}"));
        assert!(of_mesh > PIXELS / 20, "{of_mesh}");
    }
}

/// Where nothing moves, or is not to: the mesh as it is in frame i + 1, whether its image is given or drawn.
#[test]
fn a_mesh_that_is_not_blurred_has_its_own_depth() {
    for (toon, strength) in [(false, 1.0), (true, 1.0), (false, 0.0), (true, 0.0)] {
        let settings = Settings { strength, ..Settings::default() };
        let Some(mut scene) = Scene::new(settings, Some((true, f32::INFINITY)), toon) else { return };
        scene.render(true, true);
        if strength > 0.0 {
            scene.render(false, false);
        }
        let (found, samples) = (scene.rig.host_depths(), scene.seen(I + 1));
        let of_mesh = compare(&found, &samples, &scene.rig, scene.terms(), &format!("{toon}, {strength}"));
        assert!(of_mesh > PIXELS / 20, "{of_mesh}");
    }
}

#[test]
fn what_the_host_has_drawn_nearer_hides_the_mesh() {
    for convention in CONVENTIONS {
        let Some(mut scene) = Scene::new(incomplete(), Some(convention), false) else { return };
        scene.render(true, true);
        let (free, depths) = (scene.rig.picture(), scene.rig.host_depths());
        scene.render(false, false);
        let image = scene.rig.picture();
        let far = std::mem::replace(&mut scene.rig.wall, 0.0);
        let mut of_mesh: Vec<f32> = depths.iter().copied().filter(|depth| *depth != far).collect();
        of_mesh.sort_by(f32::total_cmp);
        let wall = of_mesh[of_mesh.len() / 2];
        scene.rig.wall = wall;
        scene.render(false, true);
        let (picture, found) = (scene.rig.picture(), scene.rig.host_depths());
        let mut counts = [0; 2];
        for pixel in 0..PIXELS {
            if depths[pixel] == far {
                assert_eq!(found[pixel], wall, "pixel {pixel}: an edge, or nothing");
                continue;
            }
            let in_front = (depths[pixel] >= wall) == convention.0 || depths[pixel] == wall;
            let (shown, expected) = if in_front { (&free, depths[pixel]) } else { (&image, wall) };
            assert!(picture[pixel] == shown[pixel] && found[pixel] == expected, "{convention:?}, pixel {pixel}");
            counts[usize::from(in_front)] += usize::from(free[pixel] != image[pixel]);
        }
        assert!(counts.iter().all(|count| *count > 200), "{convention:?}: {counts:?}");
    }
}

#[test]
fn a_depth_changes_no_pixel_of_the_picture() {
    for toon in [false, true] {
        let mut pictures = Vec::new();
        for depth in [None, Some((true, f32::INFINITY))] {
            let Some(mut scene) = Scene::new(Settings::default(), depth, toon) else { return };
            scene.set_images(0.25);
            scene.render(true, true);
            let has_step = scene.rig.steps().contains(&"blur.depth");
            let skipped = scene.rig.blur().skipped().any(|skipped| skipped == ("blur.depth", "the host has no depth"));
            assert_eq!((has_step, skipped), (depth.is_some(), depth.is_none()), "paid only where there is one");
            let colours: Vec<[f32; 4]> = scene.rig.layer(layout::COLOUR_LAYER);
            pictures.push((scene.rig.picture(), colours));
        }
        assert!(pictures[0] == pictures[1], "toon {toon}: to the bit");
    }
}

/// What an effect behind the mesh is told: its share of each pixel, of the colour that it has in the picture.
#[test]
fn edges_are_the_meshs_share_of_each_pixel() {
    // Two images of one colour each, so that what is the mesh's and what is not is known.
    let settings = Settings { skirt: 0.0, ..incomplete() };
    let Some(mut scene) = Scene::new(settings, Some((true, f32::INFINITY)), false) else { return };
    for frame in 0..2 {
        scene.rig.set_image(frame, &[[0.5, 0.25, 1.0, 1.0]; PIXELS]);
    }
    scene.render(true, true);
    let samples = scene.distorted();
    let rows: Vec<[u32; 4]> = scene.rig.layer(layout::SURFACE);
    let (mut edges, mut compared) = (0, 0);
    for (pixel, [_, _, depth, _]) in rows.iter().enumerate() {
        let width = SIZE[0] as usize;
        let (x, y) = (2 * (pixel % width), 2 * (pixel / width));
        let at = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (y + dy) * 2 * width + x + dx);
        if at.iter().any(|at| samples.raster.uncertain[*at]) {
            continue;
        }
        compared += 1;
        let depths = at.map(|at| samples.raster.depth[at]);
        let nearest = depths.into_iter().fold(f64::INFINITY, f64::min);
        if depths.iter().any(|depth| (nearest - 0.98 * depth).abs() < 1e-4) {
            continue;
        }
        // Of the nearest part of the mesh.
        let count = depths.iter().filter(|depth| depth.is_finite() && nearest >= 0.98 * **depth).count();
        let share = share_of(rows[pixel]);
        // A half has 11 bits.
        assert!((share - 0.25 * count as f32).abs() < 1e-3, "pixel {pixel}: {share} of {count} samples");
        assert_eq!(f32::from_bits(*depth).is_finite(), count > 0);
        edges += usize::from((1..4).contains(&count));
    }
    assert!(compared > PIXELS * 7 / 10 && edges > 50, "{compared}, {edges}");
}

/// The layer of objects, where frames are smeared and where nothing moves, of images and of frames that are drawn.
#[test]
fn samples_know_the_objects_that_they_see() {
    // The grid torn into two, of which neither has the number 0, nor the one after the other.
    const FIRST: u32 = 3;
    let [columns, rows] = SIDES;
    let objects: Vec<u32> = (0..columns * rows).map(|at| if at / columns < FIRST { 7 } else { 4 }).collect();
    let whole = grid(SIDES);
    let is_of_one =
        |triangle: &&[u32; 3]| triangle.map(|at| objects[at as usize]).windows(2).all(|two| two[0] == two[1]);
    let triangles: Vec<[u32; 3]> = whole.triangles().iter().filter(is_of_one).copied().collect();
    let mesh = || {
        let (vertices, objects) = (objects.len(), Some(&objects[..]));
        Mesh::new(&MeshInput { vertices, triangles: &triangles, objects, weld: None, normals: None, rest: None })
    };
    // In ascending order of the objects.
    let number = |base: u32| if objects[triangles[base as usize][0] as usize] == 4 { 1 } else { 2 };
    for (toon, moves) in [(false, true), (false, false), (true, true), (true, false)] {
        let depth = Some((true, f32::INFINITY));
        let Some(mut scene) = Scene::of(mesh().expect("a mesh"), incomplete(), depth, toon, [0; 2]) else { return };
        scene.render(true, true);
        if !moves {
            scene.render(false, false);
        }
        let samples = if moves { scene.distorted() } else { scene.seen(I + 1) };
        let finished = scene.rig.finished();
        let base = |name: u32| if moves { finished[name as usize - 1][3] & BASE_MASK } else { name - 1 };
        let layer: Vec<[u32; 4]> = scene.rig.layer(layout::OBJECT_LAYER);
        let (mut compared, mut of_each) = (0, [0; 3]);
        for (pixel, found) in layer.iter().enumerate() {
            let width = SIZE[0] as usize;
            let (x, y) = (2 * (pixel % width), 2 * (pixel / width));
            for (i, (dx, dy)) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().enumerate() {
                let at = (y + dy) * 2 * width + x + dx;
                if !samples.raster.uncertain[at] {
                    let expected = match samples.raster.seen[at] {
                        0 => 0,
                        name => number(base(name)),
                    };
                    assert_eq!(found[i], expected, "toon {toon}, moves {moves}: pixel {pixel}, sample {i}");
                    compared += 1;
                    of_each[expected as usize] += 1;
                }
            }
        }
        assert!(compared > 3 * PIXELS && of_each.iter().all(|count| *count > 500), "{compared}, {of_each:?}");
    }
}

/// The share that the mesh covers: the second half of the second word.
fn share_of([_, word, ..]: [u32; 4]) -> f32 {
    let (exponent, mantissa) = (word >> 26 & 31, word >> 16 & 1023);
    match exponent {
        0 => mantissa as f32 * 2.0_f32.powi(-24),
        _ => (1024 + mantissa) as f32 * 2.0_f32.powi(exponent as i32 - 25),
    }
}

/// A sheet that faces the eye, so far away that depth is known.
#[test]
fn depth_is_that_of_orthographic_views_too() {
    for reversed in [false, true] {
        let mesh = grid(SIDES);
        let mut animation = swing(SIDES, 8, SIZE, 0.3);
        // The camera looks along -z from z = 4.
        animation.cameras = vec![Camera::default(); 8];
        animation.change = match reversed {
            true => |view, frame| views::jittered(views::parallel_around(view, 4.0, 3.0), frame),
            false => |view, _| views::parallel(view, 4.0, 3.0).with_reversed(false),
        };
        animation.poses.iter_mut().for_each(|pose| pose.iter_mut().for_each(|position| position[2] = 0.5));
        let format = DepthFormat { format: vk::Format::D32_SFLOAT, reversed };
        let desc = Desc { depth: Some(format), ..desc(SIZE, &mesh, incomplete()) };
        let seen = animation.all_seen();
        let window = Window { frame: I as u32, poses: &animation.poses(&seen), current: I, between: &[] };
        let interval = Motion::new(&incomplete(), SIZE).expect("settings").interval(&mesh, &window, 1);
        let interval = interval.expect("an interval");
        let Some(rig) = BlurRig::new(desc, mesh) else { return };
        let mut scene = Scene { animation, interval, rig };
        scene.rig.wall = if reversed { 0.0 } else { 1.0 };
        scene.set_images(1.0);
        for moves in [true, false] {
            scene.render(moves, moves);
            // Between 1 and 7 metres away, at 3.5.
            let expected = if reversed { (7.0 - 3.5) / 6.0 } else { (3.5 - 1.0) / 6.0 };
            let found = scene.rig.host_depths();
            let of_mesh: Vec<f32> = found.into_iter().filter(|depth| *depth != scene.rig.wall).collect();
            assert!(of_mesh.len() > PIXELS / 20, "{reversed}, {moves}: {}", of_mesh.len());
            // Some roundings of numbers up to 12.
            let worst = of_mesh.iter().map(|depth| (depth - expected).abs()).fold(0.0, f32::max);
            assert!(worst < 2e-6, "{reversed}, {moves}: {worst} off");
        }
    }
}

/// Target, images, background and depth are parts of larger images: the same, and what lies beside stays.
#[test]
fn a_part_of_larger_images_is_as_a_whole_one() {
    let lines = Lines { count: 6, length: 2.0, width: 8.0, ..Lines::default() };
    let settings = Settings {
        ghosts: Ghosts { count: 2, step: 0.5, opacity: 0.6, ..Ghosts::default() },
        lines,
        ..Settings::default()
    };
    for toon in [false, true] {
        let outputs = [[0, 0], [7, 5]].map(|corner| {
            let mut scene = Scene::in_larger_images(settings.clone(), Some((true, f32::INFINITY)), toon, corner)?;
            let backdrop = |i: u32| [0, 1, 2, 3].map(|c| if c == 3 { 1.0 } else { random(9, i, c) });
            scene.rig.set_backdrop(&(0..PIXELS as u32).map(backdrop).collect::<Vec<_>>());
            let mut parts = Vec::new();
            for moves in [true, false] {
                scene.render(moves, moves);
                let is_drawn = ["blur.lines", "blur.ghosts"].iter().all(|name| scene.rig.steps().contains(name));
                assert_eq!(is_drawn, moves);
                parts.push((scene.rig.picture(), scene.rig.host_depths()));
                let (colours, depths) = scene.rig.beside();
                assert!(colours.iter().all(|colour| *colour == BESIDE), "toon {toon}, moves {moves}");
                assert!(depths.iter().all(|depth| *depth == scene.rig.wall), "toon {toon}, moves {moves}");
                assert_eq!(colours.is_empty(), corner == [0, 0]);
            }
            Some(parts)
        });
        let [Some(whole), Some(part)] = outputs else { return };
        for (moves, (whole, part)) in [true, false].into_iter().zip(whole.iter().zip(&part)) {
            let off = |i: usize| (0..4).map(|c| (whole.0[i][c] - part.0[i][c]).abs()).fold(0.0, f32::max);
            // A rasteriser may round elsewhere what it interpolates along a speed line; all else is the same to the bit.
            let worst = (0..PIXELS).map(off).fold(0.0, f32::max);
            let differing = (0..PIXELS).filter(|i| off(*i) > 0.0).count();
            assert!(worst < 1e-5 && differing < PIXELS / 200, "toon {toon}, moves {moves}: {worst}, {differing}");
            assert!(whole.1 == part.1, "toon {toon}, moves {moves}: depth to the bit");
        }
    }
}

/// Frames that are drawn are hidden, too: their background is seen there, and nothing of the mesh.
#[test]
fn what_the_host_has_drawn_nearer_hides_frames_that_are_drawn() {
    let behind = [0.25, 0.5, 0.75, 1.0];
    for (convention, strength, moves) in [
        (CONVENTIONS[0], 1.0, true),
        (CONVENTIONS[1], 1.0, false),
        (CONVENTIONS[2], 1.0, true),
        (CONVENTIONS[1], 0.0, true),
    ] {
        let settings = Settings { strength, ..incomplete() };
        let Some(mut scene) = Scene::new(settings, Some(convention), true) else { return };
        scene.render(true, moves);
        let (free, depths) = (scene.rig.picture(), scene.rig.host_depths());
        let far = scene.rig.wall;
        let mut of_mesh: Vec<f32> = depths.iter().copied().filter(|depth| *depth != far).collect();
        of_mesh.sort_by(f32::total_cmp);
        let wall = of_mesh[of_mesh.len() / 2];
        scene.rig.wall = wall;
        scene.render(false, moves);
        let picture = scene.rig.picture();
        let mut counts = [0; 2];
        for pixel in (0..PIXELS).filter(|pixel| depths[*pixel] != far) {
            let in_front = (depths[pixel] >= wall) == convention.0 || depths[pixel] == wall;
            let expected = if in_front { free[pixel] } else { behind };
            assert!(
                picture[pixel] == expected,
                "{convention:?}, {strength}, {moves}, pixel {pixel}: {:?}",
                picture[pixel]
            );
            counts[usize::from(in_front)] += 1;
        }
        assert!(counts.iter().all(|count| *count > 200), "{convention:?}: {counts:?}");
    }
}
