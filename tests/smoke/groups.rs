//! Depth groups and lists against the reference.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::low_level::smoke::params::Control;
use celfx::program;
use celfx::simulate::smoke::Builtin;
use celfx::smoke::reference::groups::{Groups, Ranges};
use celfx::smoke::reference::particles::Origin;
use celfx::smoke::reference::render::raycast;
use celfx::smoke::settings::{Mask, Shadow};
use celfx::smoke::{Sequence, Settings};
use celfx::view::Camera;
use glam::DVec3;

use crate::common::bench::{Bench, Given};
use crate::common::rig::{Rig, scene};
use crate::common::scenes::{camera, desc, direction, random, volume};

const COUNT: u32 = 600;
/// Spheres are the test's own.
const WRITTEN: &[&str] = &["smoke.restart", "smoke.advect", "smoke.grow"];

fn spheres(key: u32) -> Vec<[f32; 4]> {
    (0..COUNT)
        .map(|i| {
            let p = [0, 1, 2].map(|a| 2.0 * random(key, i, a) - 1.0);
            let radius = if i % 11 == 0 { 0.0 } else { 0.02 + 0.1 * random(key, i, 3) };
            [p[0], p[1], p[2], radius]
        })
        .collect()
}

fn place() -> Volume {
    volume([4; 3], [0.5; 3], [-1.0; 3], |_, _, _| 1.0)
}

/// The spheres that can be seen, by the definition and by a margin; none where it is too close to say.
fn visible(camera: &Camera, s: &[f32; 4], half: [f64; 2]) -> Option<bool> {
    let c = camera.rotation() * (DVec3::new(s[0].into(), s[1].into(), s[2].into()) - camera.eye);
    let r = f64::from(s[3]);
    let mut gap = (c.z + r - camera.near).min(camera.far - (c.z - r));
    for (across, slope) in [(c.x, half[0]), (c.y, half[1])] {
        gap = gap.min(r - (across.abs() - slope * c.z) / (1.0 + slope * slope).sqrt());
    }
    // The effect may keep spheres that miss the screen by a ten-thousandth.
    (r > 0.0 && gap.abs() > 2e-4 * r + 1e-5 || r == 0.0).then_some(r > 0.0 && gap > 0.0)
}

fn assert_groups(name: &str, settings: &Settings, cameras: impl Fn(u32) -> Camera) {
    let size = [64, 40];
    let Some(mut bench) = Bench::new(desc(size, [4; 3], settings.clone())) else { return };
    let mut reference = Groups::default();
    let (mut apart, mut total) = (0, 0);
    for frames in 0..30 {
        // Every tenth frame the spheres jump: ranges that do not overlap start afresh.
        let spheres = spheres(3 + frames / 10);
        let camera = cameras(frames);
        bench.write(layout::SPHERES, &spheres);
        let light = direction(-1.0, -1.0, -1.0);
        bench.run(&Given { camera, light, volume: &place(), frames, rendered: false, omit: WRITTEN });
        let actual: Vec<u32> = bench.read(layout::GROUPS, spheres.len());
        let exact: Vec<[f64; 4]> = spheres.iter().map(|s| s.map(f64::from)).collect();
        let origin = if frames == 0 { Origin::Fresh } else { Origin::Kept };
        let expected = reference.step(settings, &camera.view([1, 1]), &exact, &vec![origin; spheres.len()]);
        assert_ranges(&mut bench, &reference);
        apart += actual.iter().zip(&expected).filter(|(a, e)| a != e).count();
        total += actual.len();
        assert!(actual.iter().zip(&expected).all(|(a, e)| (*a == 0) == (*e == 0)), "{name}: who has a group");
        assert_lists(&mut bench, &camera, &spheres);
    }
    println!("{name}: {apart} of {total} groups differ");
    // Depths are rounded to some 3e-7 of the range, and a group is an eighth of it or less: a sphere is that near to a
    // border with a chance of 5e-6 a frame, and hysteresis keeps what was decided.
    assert!(apart <= 3 * 30, "{name}: {apart} of {total} differ");
}

/// What the soft mask goes by, where there is something that can be seen.
fn assert_ranges(bench: &mut Bench, reference: &Groups) {
    if reference.range().is_none() {
        return;
    }
    let Control { group_start, groups_per_metre, .. } = bench.read::<Control>(layout::CONTROL, 1)[0];
    let Ranges { start, width, count } = reference.ranges(&bench.desc.settings);
    // Depths of some metres are rounded to some 3e-7 of themselves.
    assert!((f64::from(group_start) - start).abs() < 2e-6, "{group_start}, not {start}");
    let inverse = if width > 0.0 { width.recip() } else { 0.0 };
    assert!((f64::from(groups_per_metre) / inverse - 1.0).abs() < 1e-5, "{groups_per_metre}, not {inverse} ({count})");
}

/// The two lists: in particle order, complete, and counted.
fn assert_lists(bench: &mut Bench, camera: &Camera, spheres: &[[f32; 4]]) {
    let control = bench.read::<Control>(layout::CONTROL, 1)[0];
    let live: Vec<u32> = bench.read(layout::LIVE, control.live as usize);
    let seen: Vec<u32> = bench.read(layout::VISIBLE, control.visible as usize);
    let expected: Vec<u32> = (0..COUNT).filter(|i| spheres[*i as usize][3] > 0.0).collect();
    assert_eq!(live, expected);
    assert!(seen.is_sorted_by(|a, b| a < b), "{seen:?}");
    let half = camera.half_extent(bench.desc.size).to_array();
    for (slot, sphere) in spheres.iter().enumerate() {
        if let Some(visible) = visible(camera, sphere, half) {
            assert_eq!(seen.binary_search(&(slot as u32)).is_ok(), visible, "slot {slot}: {sphere:?}");
        }
    }
    assert_eq!(control.draw, [4, control.visible, 0, 0]);
    assert_eq!(control.light_draw, [4, control.live, 0, 0]);
    assert_eq!(control.live_groups[0], control.live.div_ceil(64));
}

fn settings() -> Settings {
    Settings { particles: COUNT, fade: 0, mask: Mask::Groups, ..Settings::default() }
}

#[test]
fn groups_with_hysteresis_are_those_of_the_reference() {
    let turning = |frame: u32| camera(2.0 * f64::from(frame));
    assert_groups("default", &settings(), turning);
    assert_groups("no smoothing", &Settings { range_smoothing: 0.0, groups: 20, ..settings() }, turning);
    assert_groups("no hysteresis", &Settings { hysteresis: 0.0, groups: 3, ..settings() }, turning);
    assert_groups("254", &Settings { groups: 254, ..settings() }, turning);
    assert_groups("one", &Settings { groups: 1, ..settings() }, turning);
    assert_groups("fixed depth", &Settings { group_depth: Some(0.03), ..settings() }, turning);
    assert_groups("soft", &Settings { mask: Mask::Soft, ..settings() }, turning);
}

#[test]
fn groups_while_the_camera_flies_through_and_away() {
    let flying = |frame: u32| {
        let z = 3.0 - 0.25 * f64::from(frame);
        Camera { eye: DVec3::new(0.1, 0.0, z), target: DVec3::new(0.1, 0.0, z - 1.0), ..camera(0.0) }
    };
    assert_groups("flying", &settings(), flying);
}

/// Particles of the plume that do not move, seen by a camera that goes around them in steps (degrees): how many pixels
/// change their group from step to step, in the mean, of those whose sphere stays.
fn changing(settings: Settings, degrees: impl Fn(u32) -> f64) -> Option<f64> {
    let volume = Builtin::Plume.volume(48, 24.0);
    let size = [200, 200];
    let mut rig = Rig::new(desc(size, volume.dimensions, settings))?;
    let target = DVec3::new(0.0, 1.1, 0.0);
    let mut previous: Option<Vec<(usize, u32)>> = None;
    let mut changed = Vec::new();
    for step in 0..=40 {
        let (sin, cos) = degrees(step).to_radians().sin_cos();
        let eye = target + 4.5 * DVec3::new(sin, 0.1, cos);
        let camera = Camera { eye, target, vertical_fov: 32.0, ..Camera::default() };
        let sequence = if step == 0 { Sequence::Restart } else { Sequence::Advance };
        let light = direction(-1.0, -1.5, -1.0);
        rig.frame(&scene(sequence, camera, light, (step == 0).then_some(&volume)));
        let groups = rig.groups();
        let spheres: Vec<[f64; 4]> = rig.spheres().iter().map(|s| s.map(f64::from)).collect();
        let hits = raycast(&camera.view(size), size, &spheres);
        let seen: Vec<_> =
            hits.iter().map(|hit| hit.map_or((usize::MAX, 0), |h| (h.sphere, groups[h.sphere]))).collect();
        if let Some(previous) = &previous {
            let stays = || previous.iter().zip(&seen).filter(|(a, b)| a.0 == b.0 && a.0 != usize::MAX);
            assert!(stays().count() > 4000, "too little is seen: {}", stays().count());
            changed.push(stays().filter(|(a, b)| a.1 != b.1).count() as f64 / stays().count() as f64);
        }
        previous = Some(seen);
    }
    Some(changed.iter().sum::<f64>() / changed.len() as f64)
}

fn plume() -> Settings {
    Settings { particles: 500, mask: Mask::Groups, sigma: 0.0, shadow: Shadow::None, ..Settings::default() }
}

#[test]
fn groups_do_not_flicker_when_the_camera_shakes() {
    let shake = |step: u32| 0.5 * f64::from(step % 2);
    let Some(mean) = changing(plume(), shake) else { return };
    let Some(without) = changing(Settings { hysteresis: 0.0, range_smoothing: 0.0, ..plume() }, shake) else { return };
    println!("shaking: {:.4} %, without hysteresis and smoothing {:.4} %", 100.0 * mean, 100.0 * without);
    // The bound of the specification: 0.05 % in the mean over 40 steps of 0.5 degree. Without hysteresis it is missed.
    assert!(mean <= 5e-4, "{mean}");
    assert!(without > 5e-4, "{without}: the test shows nothing");
}

#[test]
fn groups_change_rarely_when_the_camera_goes_around() {
    let turn = |step: u32| 0.5 * f64::from(step);
    let shot = program::load("builtin:smoke", &[])
        .expect("a built-in shot")
        .part::<program::smoke::Smoke>()
        .expect("smoke")
        .settings
        .clone();
    // No lives end and nothing is filtered or shadowed: only groups are looked at.
    let shot = Settings { lifetime: None, mask: Mask::Groups, sigma: 0.0, shadow: Shadow::None, ..shot };
    let Some(mean) = changing(shot, turn) else { return };
    let Some(default) = changing(plume(), turn) else { return };
    println!("turning: {:.4} %, with the default groups {:.3} %", 100.0 * mean, 100.0 * default);
    // The bound of the specification, which the built-in smoke keeps with five groups and a hysteresis of one half.
    assert!(mean <= 5e-4, "{mean}");
    // Eight groups of the smoke's own depth and a hysteresis of 0.2 cannot: over 20 degrees spheres really move by up to
    // a group and a half. One at 0.3 m to the side moves 2.6 mm a step, 2 % of a group of 0.13 m.
    assert!(default <= 0.01, "{default}");
}
