//! Motion vectors and reactive mask of the mesh, against splines in f64: where what each sample sees is at k', and where it was a frame
//! earlier.

use ash::vk;
use celfx::blur::motion::PixelClip;
use celfx::blur::reference::distort::{Drawing, Fragment};
use celfx::blur::settings::Space;
use celfx::blur::{Background, DepthFormat, Desc, Mesh, Settings};
use celfx::host::TemporalFormats;
use celfx::low_level::shaders::common::constants::LEAST_SHARE;
use celfx::simulate::mesh::Builtin;
use celfx::view::Light;
use glam::{DVec2, DVec3};

use crate::common::blur::{BlurRig, Shot, desc, incomplete};
use crate::common::temporal::{FORMATS, Found, HOSTS, distance};
use crate::common::views;
use crate::scenes::{Animation, Change, drawn, grid, interval, natural, spline, swing};
use crate::toon::Film;

const SIZE: [u32; 2] = [240, 136];
const SIDES: [u32; 2] = [12, 9];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
/// What the host has in the mask.
const SHARE: f32 = 0.375;

/// The left columns stay where they are, but for what the camera does.
fn labels() -> Vec<u32> {
    (0..SIDES[0] * SIDES[1]).map(|point| u32::from(point % SIDES[0] >= 3)).collect()
}

fn settings() -> Settings {
    // Triangles are so small that k' is all that matters.
    Settings { tolerance: 0.5, ..incomplete() }
}

fn render(rig: &mut BlurRig, animation: &Animation, i: usize) -> Found {
    let segments = rig.desc().segments as usize;
    let interval = interval(animation, i, &labels(), 0.5, 12, segments);
    let knots = animation.knots(i, segments);
    let poses = Some((0, &animation.poses[..]));
    let shot = Shot { poses, interval: Some(&interval), views: animation.views(i), knots: Some(&knots) };
    rig.share = SHARE;
    rig.frame(&shot).expect("a frame");
    rig.found()
}

/// The four samples of a pixel.
fn samples(drawing: &Drawing, pixel: usize) -> [Option<Fragment>; 4] {
    let [x, y] = [pixel % SIZE[0] as usize, pixel / SIZE[0] as usize];
    let width = 2 * SIZE[0] as usize;
    [0, 1, 2, 3].map(|i| drawing.fragments[(2 * y + i / 2) * width + 2 * x + i % 2])
}

/// What is seen of a place of the mesh: pixels, without jitter, so many frames after frame i.
fn seen(animation: &Animation, mesh: &Mesh, space: Space, i: usize, fragment: &Fragment, time: f64) -> DVec2 {
    let channels = |point: u32| {
        let clip = |frame: usize| {
            let clip =
                PixelClip::new(&animation.seen(frame), [0.0; 2], SIZE).clip(animation.poses[frame][point as usize]);
            if space == Space::Screen { (clip.truncate() / clip.z).extend(clip.z) } else { clip }
        };
        (0..animation.poses.len()).map(clip).collect::<Vec<DVec3>>()
    };
    let corners = mesh.triangles()[fragment.base as usize];
    let of = |(point, weight): (u32, f64)| {
        let values = channels(point);
        spline(&values, &natural(&values), i, time).0 * weight
    };
    let sum: DVec3 = corners.into_iter().zip(fragment.weights).map(of).sum();
    if space == Space::Screen { sum.truncate() } else { sum.truncate() / sum.z }
}

#[test]
fn vectors_are_differences_along_trajectories() {
    let (mut early, mut faint) = (0, 0);
    let screen = Settings { space: Space::Screen, ..settings() };
    let strong = Settings { strength: 2.5, ..settings() };
    let straight: Change = |view, _| view;
    let moved: Change = |view, frame| views::jittered(views::moved(view), frame);
    let mirrored: Change = |view, frame| views::jittered(views::mirrored(views::squeezed(view)), frame);
    for (name, settings, change, i) in [
        ("straight", settings(), straight, 3),
        ("jittered, off-centre", settings(), moved, 3),
        ("mirrored", settings(), mirrored, 4),
        ("first", settings(), moved, 0),
        ("last", settings(), straight, 6),
        ("screen", screen, moved, 3),
        ("strong", strong, moved, 4),
    ] {
        let (mesh, animation) = (grid(SIDES), Animation { change, ..swing(SIDES, 8, SIZE, 0.3) });
        let (space, made) = (settings.space, Desc { temporal: FORMATS, ..desc(SIZE, &mesh, settings) });
        let Some(mut rig) = BlurRig::in_larger_images(made, mesh.clone(), [5, 2]) else { return };
        let found = render(&mut rig, &animation, i);
        let drawing = drawn(&mut rig, &mesh, &animation, [i, i + 1]);
        let (mut worst, mut rough, mut counts, mut apart) = (0.0_f64, 0, [0; 3], 0);
        for pixel in 0..PIXELS {
            let samples = samples(&drawing, pixel);
            let is_still = |fragment: &Fragment| {
                mesh.triangles()[fragment.base as usize].iter().all(|point| labels()[*point as usize] == 0)
            };
            let share = samples.iter().flatten().filter(|fragment| !is_still(fragment)).count() as f32 / 4.0;
            // Where the mesh's border is next to a sample, rounding decides.
            let shown = samples.iter().flatten().count() as f32 / 4.0;
            let is_same =
                (found.motion[pixel] != HOSTS) == (shown >= LEAST_SHARE) && found.reactive[pixel] == share.max(SHARE);
            apart += usize::from(!is_same);
            faint += usize::from(shown > 0.0 && shown < LEAST_SHARE);
            let Some(nearest) = samples.iter().flatten().min_by(|a, b| a.depth.total_cmp(&b.depth)) else { continue };
            // As near are others of the same triangle, which another point is seen at, or what rounding decides.
            let ties = samples.iter().flatten().filter(|other| other.depth < nearest.depth * (1.0 + 1e-6)).count();
            if !is_same || shown < LEAST_SHARE || ties > 1 {
                continue;
            }
            let at = |time| seen(&animation, &mesh, space, i, nearest, time);
            let expected = at(nearest.time - 1.0) - at(nearest.time);
            let off = distance(found.motion[pixel], expected);
            worst = worst.max(off);
            rough += usize::from(off >= 0.01);
            counts[0] += 1;
            counts[1] += usize::from(is_still(nearest));
            counts[2] += usize::from(nearest.time < 0.5);
        }
        println!(
            "{name}: {counts:?} vectors, {rough} rough, off by at most {worst:.1e} pixels; {apart} pixels at borders"
        );
        // Pieces of refined triangles are flat: places are off by up to `tolerance`, 0.06 pixels here, and vectors by what a place that is
        // so far away moves otherwise, a few hundredths of that. Vectors are some 10 pixels long.
        // Beside a seam, where k' changes by as much as one in a pixel, a place that is off by 0.01 pixels is another time: that is some
        // 0.1 pixels of the way.
        assert!(worst < 0.2 && rough * 200 < counts[0], "{name}: {rough} of {} rough, off by {worst}", counts[0]);
        assert!(counts[0] > 1000 && counts[1] > 100 && apart * 500 < counts[0], "{name}: {counts:?}, {apart}");
        early += counts[2];
    }
    assert!(early > 300, "{early} vectors reach back before frame i by half a frame");
    assert!(faint > 50, "{faint} pixels show less than half of the mesh, and have no vector");
}

/// The interval says what the frame before was seen through, and what else is said of it must be the same, but for jitter.
#[test]
fn the_view_before_is_the_intervals() {
    let (mesh, animation) = (grid(SIDES), swing(SIDES, 8, SIZE, 0.3));
    let Some(mut rig) = BlurRig::new(Desc { temporal: FORMATS, ..desc(SIZE, &mesh, settings()) }, mesh.clone()) else {
        return;
    };
    let found = render(&mut rig, &animation, 3);
    rig.previous = Some(views::jittered(animation.seen(3), 1));
    assert!(render(&mut rig, &animation, 3).bits() == found.bits());
    rig.previous = Some(animation.seen(2));
    let segments = rig.desc().segments as usize;
    let interval = interval(&animation, 3, &labels(), 0.5, 12, segments);
    let knots = animation.knots(3, segments);
    let shot = Shot { poses: None, interval: Some(&interval), views: animation.views(3), knots: Some(&knots) };
    let said = rig.frame(&shot).expect_err("another view").to_string();
    assert_eq!(said, "temporal.previous: another view than the interval's of frame i");
}

/// Everything moves evenly, seen in parallel rays: k' does not matter.
#[test]
fn what_moves_evenly_has_one_vector_in_parallel_rays() {
    let mesh = grid(SIDES);
    let change: Change = |view, frame| views::jittered(views::parallel_around(view, 4.0, 3.0), frame);
    let base = swing(SIDES, 1, SIZE, 0.3);
    let step = DVec3::new(0.13, 0.07, 0.02);
    let pose = |frame: usize| {
        let way = (step * frame as f64).as_vec3().to_array();
        base.poses[0].iter().map(|p| [0, 1, 2].map(|axis| p[axis] + way[axis])).collect()
    };
    let animation =
        Animation { poses: (0..6).map(pose).collect(), cameras: vec![base.cameras[0]; 6], change, size: SIZE };
    let Some(mut rig) = BlurRig::new(Desc { temporal: FORMATS, ..desc(SIZE, &mesh, settings()) }, mesh.clone()) else {
        return;
    };
    let found = render(&mut rig, &animation, 2);
    let at =
        |frame: usize| PixelClip::new(&animation.seen(2), [0.0; 2], SIZE).clip(animation.poses[frame][0]).truncate();
    let expected = at(1) - at(2);
    let vectors = || found.motion.iter().filter(|vector| **vector != HOSTS);
    let worst = vectors().map(|vector| distance(*vector, expected)).fold(0.0, f64::max);
    println!("{} vectors of {expected}, off by at most {worst:.1e} pixels", vectors().count());
    // Poses are rounded to 6e-8 m of some 40 pixels, and clip coordinates to 2e-5 pixels.
    assert!(worst < 1e-4 && vectors().count() > 2000 && expected.length() > 3.0, "off by {worst}");
}

/// Whether frames are drawn or images, with depth or without: outputs change no bit, and are not where nothing moves.
#[test]
fn outputs_change_no_bit_of_the_picture() {
    let made = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };
    for depth in [None, Some(made)] {
        let films =
            [(TemporalFormats::default(), false), (FORMATS, false), (FORMATS, true)].map(|(temporal, layers)| {
                Film::described(Builtin::Crossing, 800, 18..26, |mesh| Desc {
                    temporal,
                    depth,
                    toon: true,
                    layers,
                    ..desc(SIZE, mesh, incomplete())
                })
            });
        let [Some(mut plain), Some(mut film), Some(mut kept)] = films else { return };
        for film in [&mut plain, &mut film, &mut kept] {
            film.set_light(Light::default(), Background::Clear([0.1, 0.2, 0.3, 1.0]));
        }
        for i in 1..3 {
            assert!(film.output(i, true) == plain.output(i, true), "output {i}, depth: {}", depth.is_some());
            let found = film.rig.found();
            // What they go back to has not made room for anything.
            kept.output(i, true);
            let whole = kept.rig.found();
            assert!(found.motion == whole.motion && found.reactive == whole.reactive, "output {i}");
            let count = found.motion.iter().filter(|vector| **vector != HOSTS).count();
            let smeared = found.reactive.iter().filter(|share| **share > 0.0).count();
            assert!(count > 500 && smeared > 500, "{count} vectors, {smeared} smeared");
        }
        if depth.is_some() {
            // A wall before everything.
            film.rig.wall = 1.0;
            film.output(2, true);
            let found = film.rig.found();
            assert!(found.motion.iter().all(|vector| *vector == HOSTS), "vectors of what is hidden");
            assert!(found.reactive.iter().all(|share| *share == 0.0), "a mask of what is hidden");
            film.rig.wall = 0.0;
        }
        film.output(2, false);
        let found = film.rig.found();
        assert!(found.motion.iter().all(|vector| *vector == HOSTS), "nothing moves");
        let skipped: Vec<_> = film.rig.blur().skipped().filter(|(_, reason)| *reason == "nothing moves").collect();
        assert!(["blur.motion", "blur.reactive"].iter().all(|name| skipped.iter().any(|(other, _)| other == name)));
    }
}
