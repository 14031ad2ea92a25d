//! What the host has drawn before the mesh: it is not taken for the mesh.

use ash::vk;
use celfx::blur::motion::{Motion, Window};
use celfx::blur::settings::{Completion, Mix};
use celfx::blur::{DepthFormat, Desc, Interval, Settings};
use celfx::low_level::blur::layout;
use celfx::view::Projection;

use crate::common::blur::{BlurRig, Shot, desc};
use crate::common::scenes::random;
use crate::common::views;
use crate::scenes::{Animation, Change, grid, swing};

const SIDES: [u32; 2] = [9, 7];
const SIZE: [u32; 2] = [160, 120];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
const I: usize = 3;
/// What stands before the mesh, and how far away it is in metres; the mesh is some 4 away.
const ORANGE: [f32; 4] = [1.0, 0.5, 0.0, 1.0];
const BAR_DEPTH: f64 = 2.0;

/// Whether a bar stands before a pixel in a frame: it goes to the right by three pixels a frame.
fn is_bar(frame: usize, pixel: usize) -> bool {
    let x = pixel % SIZE[0] as usize;
    (70 + 3 * frame..88 + 3 * frame).contains(&x)
}

struct Scene {
    animation: Animation,
    interval: Interval,
    rig: BlurRig,
}

/// What a depth image shows besides the bar.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Around {
    /// Nothing.
    Nothing,
    /// The mesh itself, and a wall behind it.
    All,
}

impl Scene {
    fn new(settings: Settings, change: Change, occluders: Option<DepthFormat>) -> Option<Scene> {
        let (mesh, animation) = (grid(SIDES), Animation { change, ..swing(SIDES, 8, SIZE, 0.3) });
        let seen = animation.all_seen();
        let window = Window { frame: I as u32, poses: &animation.poses(&seen), current: I, between: &[] };
        let interval = Motion::new(&settings, SIZE).expect("settings").interval(&mesh, &window, 1);
        let rig = BlurRig::new(Desc { occluders, ..desc(SIZE, &mesh, settings) }, mesh)?;
        Some(Scene { animation, interval: interval.expect("an interval"), rig })
    }

    /// Images of a blue mesh, behind the bar.
    fn set_images(&mut self, names: &[Vec<u32>; 2]) {
        for (side, names) in names.iter().enumerate() {
            let pixel = |pixel: usize| match (is_bar(I + side, pixel), names[pixel] > 0) {
                (true, _) => ORANGE,
                (false, true) => [0.0, 0.2 + 0.2 * random(3, pixel as u32, 1), 1.0, 1.0],
                (false, false) => [0.0, 0.0, 0.3, 1.0],
            };
            self.rig.set_image(side, &(0..PIXELS).map(pixel).collect::<Vec<_>>());
        }
    }

    /// Their depth.
    fn set_occluders(&mut self, names: &[Vec<u32>; 2], around: Around) {
        for (side, names) in names.iter().enumerate() {
            let projection = Projection::of_valid(&self.animation.seen(I + side), SIZE);
            let [offset, factor] = projection.depth_terms;
            let held = |z: f64| (offset + factor * if projection.is_orthographic { z } else { 1.0 / z }) as f32;
            // Depth is counted from the eye: behind the near plane there are 2 metres before the mesh, and some behind.
            let (bar, wall) = if projection.is_orthographic {
                (projection.near + 1.0, projection.far - 0.5)
            } else {
                (BAR_DEPTH, 6.0)
            };
            let empty = if (factor > 0.0) != projection.is_orthographic { 0.0 } else { 1.0 };
            let mesh = self.mesh_depths(I + side, &projection);
            let pixel = |pixel: usize| match (is_bar(I + side, pixel), around) {
                (true, _) => held(bar),
                (false, Around::Nothing) => empty,
                // As another rasteriser may have rounded it.
                (false, Around::All) if names[pixel] > 0 => {
                    held(mesh[pixel] * (1.0 + 1e-4 * (pixel % 3) as f64 - 1e-4))
                }
                (false, Around::All) => held(wall),
            };
            self.rig.set_occluders(1 + side, &(0..PIXELS).map(pixel).collect::<Vec<_>>());
        }
    }

    /// View depth of the mesh's nearest plane at each pixel's centre, where it is seen.
    fn mesh_depths(&self, frame: usize, projection: &Projection) -> Vec<f64> {
        let mesh = grid(SIDES);
        let at =
            |point: u32| projection.to_view(glam::Vec3::from(self.animation.poses[frame][point as usize]).as_dvec3());
        let mut depths = vec![f64::INFINITY; PIXELS];
        for triangle in mesh.triangles() {
            let corners = triangle.map(at);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            for (pixel, nearest) in depths.iter_mut().enumerate() {
                let centre = glam::DVec2::new((pixel as u32 % SIZE[0]) as f64, (pixel as u32 / SIZE[0]) as f64) + 0.5;
                let [from, way] = projection.ray_at(centre);
                let depth = normal.dot(corners[0] - from) / normal.dot(way);
                let place = from + depth * way;
                let sides =
                    [0, 1, 2].map(|i| (corners[(i + 1) % 3] - corners[i]).cross(place - corners[i]).dot(normal));
                // A pixel's centre near an edge may be seen either way.
                if sides.iter().all(|side| *side >= -1e-3 * normal.length_squared()) && depth < *nearest {
                    *nearest = depth;
                }
            }
        }
        depths
    }

    fn render(&mut self, is_first: bool) -> Vec<[f32; 4]> {
        let poses = is_first.then_some((0, &self.animation.poses[..]));
        let views = self.animation.views(I);
        self.rig.frame(&Shot { poses, interval: Some(&self.interval), views, knots: None }).expect("a frame");
        self.rig.picture()
    }

    fn names(&mut self) -> [Vec<u32>; 2] {
        [layout::PREVIOUS_NAMES, layout::NEXT_NAMES].map(|id| self.rig.layer(id))
    }
}

/// What each frame sees of the mesh if nothing stands before it.
fn unhidden(change: Change) -> Option<[Vec<u32>; 2]> {
    let mut scene = Scene::new(Settings::default(), change, None)?;
    scene.render(true);
    Some(scene.names())
}

/// Pixels of the output that show orange and are not behind the bar of frame i + 1.
fn smeared(picture: &[[f32; 4]]) -> usize {
    (0..PIXELS).filter(|pixel| !is_bar(I + 1, *pixel) && picture[*pixel][0] > 1e-3).count()
}

#[test]
fn what_stands_before_the_mesh_is_not_smeared() {
    let changes: [(Change, bool, bool); 3] = [
        (|view, _| view, true, false),
        (|view, frame| views::jittered(views::moved(view), frame).with_reversed(false), false, true),
        (|view, _| views::parallel_around(view, 4.0, 3.0), true, true),
    ];
    for (change, reversed, is_other) in changes {
        let made = DepthFormat { format: vk::Format::D32_SFLOAT, reversed };
        let Some(names) = unhidden(change) else { return };
        let completions = [Completion::Surface, Completion::None, Completion::Gradient];
        // What completion does with it does not depend on the view.
        let count = if is_other { 1 } else { 3 };
        for completion in completions.into_iter().take(count) {
            let settings = Settings { completion, mix: Mix::Blend, ..Settings::default() };
            let Some(mut plain) = Scene::new(settings.clone(), change, None) else { return };
            plain.set_images(&names);
            let without = smeared(&plain.render(true));
            let Some(mut scene) = Scene::new(settings, change, Some(made)) else { return };
            scene.set_images(&names);
            let mut pictures = Vec::new();
            for around in [Around::Nothing, Around::All] {
                scene.set_occluders(&names, around);
                let picture = scene.render(pictures.is_empty());
                let with = smeared(&picture);
                eprintln!("{completion:?}, reversed {reversed}, {around:?}: {with} pixels of {without} are orange");
                assert!(without > 25 && with == 0, "{completion:?}, {around:?}: {with} of {without}");
                assert!(picture.as_flattened().iter().all(|c| c.is_finite()));
                // The bar hides the mesh, and nothing else does.
                for (side, (found, unhidden)) in scene.names().iter().zip(&names).enumerate() {
                    let expected = |pixel: usize| if is_bar(I + side, pixel) { 0 } else { unhidden[pixel] };
                    let wrong = (0..PIXELS).filter(|pixel| found[*pixel] != expected(*pixel)).count();
                    assert_eq!(wrong, 0, "{around:?}, frame {}", I + side);
                }
                pictures.push(picture);
            }
            // Whether the depth has the mesh and what is behind it does not matter, but beside outlines.
            let differing = pictures[0].iter().zip(&pictures[1]).filter(|(a, b)| a != b).count();
            assert!(differing < PIXELS / 100, "{completion:?}: {differing} pixels");
        }
    }
}

/// Without anything before the mesh depth images change nothing.
#[test]
fn what_stands_behind_the_mesh_changes_nothing() {
    let change: Change = |view, _| view;
    let Some(names) = unhidden(change) else { return };
    let made = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };
    let Some(mut plain) = Scene::new(Settings::default(), change, None) else { return };
    let Some(mut scene) = Scene::new(Settings::default(), change, Some(made)) else { return };
    for rig in [&mut plain.rig, &mut scene.rig] {
        for (side, names) in names.iter().enumerate() {
            let pixel = |pixel: usize| match names[pixel] {
                0 => [0.1, 0.2, 0.3, 1.0],
                _ => [random(side as u32, pixel as u32, 0), 0.5, 1.0, 1.0],
            };
            rig.set_image(side, &(0..PIXELS).map(pixel).collect::<Vec<_>>());
        }
    }
    let expected = plain.render(true);
    for side in 1..3 {
        scene.rig.set_occluders(side, &[0.0; PIXELS]);
    }
    assert!(scene.render(true) == expected, "nothing is there");
    // A wall behind: the mesh's outlines may lie over it as before.
    let [offset, factor] = Projection::of_valid(&scene.animation.seen(I), SIZE).depth_terms;
    for side in 1..3 {
        scene.rig.set_occluders(side, &[(offset + factor / 9.0) as f32; PIXELS]);
    }
    assert!(scene.render(false) == expected, "a wall behind");
}

/// Images of the mesh alone lie over a background that is an image.
#[test]
fn images_of_the_mesh_alone_lie_over_a_background() {
    let change: Change = |view, _| view;
    let Some(names) = unhidden(change) else { return };
    let backdrop: Vec<[f32; 4]> = (0..PIXELS as u32).map(|p| [random(5, p, 0), random(5, p, 1), 0.0, 1.0]).collect();
    let Some(mut alone) = Scene::new(Settings::default(), change, None) else { return };
    for (side, names) in names.iter().enumerate() {
        let pixel = |name: &u32| if *name > 0 { [0.0, 0.0, 1.0, 1.0] } else { [0.0; 4] };
        alone.rig.set_image(side, &names.iter().map(pixel).collect::<Vec<_>>());
    }
    alone.rig.set_backdrop(&backdrop);
    for moves in [true, false] {
        let views = alone.animation.views(I);
        let poses = moves.then_some((0, &alone.animation.poses[..]));
        let interval = moves.then_some(&alone.interval);
        alone.rig.frame(&Shot { poses, interval, views, knots: None }).expect("a frame");
        let picture = alone.rig.picture();
        let mut counts = [0; 2];
        for (pixel, [r, g, b, a]) in picture.iter().copied().enumerate() {
            // What is not the mesh's is the backdrop's: blue is a share of the one, red and green of the other.
            let behind = backdrop[pixel];
            let apart = (r - (1.0 - b) * behind[0]).abs().max((g - (1.0 - b) * behind[1]).abs());
            assert!(apart < 1e-5 && (a - 1.0).abs() < 1e-5, "moves {moves}, pixel {pixel}: {:?}", picture[pixel]);
            counts[0] += usize::from(b == 0.0);
            counts[1] += usize::from(b == 1.0);
        }
        assert!(counts.iter().all(|count| *count > 500), "{counts:?}");
    }
}
