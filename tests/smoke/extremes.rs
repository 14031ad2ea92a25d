//! Pictures, cameras, volumes and counts at the ends of what is allowed: everything stays finite and agrees.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::smoke::settings::{Emitter, Shadow};
use celfx::smoke::{Desc, Sequence, Settings};
use celfx::view::{Camera, FARTHEST, Light, LightSource, NARROWEST, WIDEST};
use glam::DVec3;

use crate::common::apart;
use crate::common::rig::{Rig, scene};
use crate::common::scenes::{camera, desc, direction, moving_puffs, of_voxels, puffs, random, volume};

/// No NaN in any layer, and no infinity but the one that means "empty".
fn assert_finite(name: &str, rig: &mut Rig) {
    let (luminance, id) = rig.pixels();
    let depth = rig.layer(layout::DEPTH);
    for pixel in 0..id.len() {
        let empty = id[pixel] == 0;
        assert_eq!(empty, depth[pixel] == f32::INFINITY, "{name}: depth {} of group {}", depth[pixel], id[pixel]);
        assert!(empty || depth[pixel].is_finite() && depth[pixel] > 0.0, "{name}: depth {}", depth[pixel]);
        assert!(luminance[pixel] <= 1.0 && (!empty || luminance[pixel] == 0.0), "{name}: {}", luminance[pixel]);
    }
    let mut layers = vec![layout::SHADOW];
    layers.extend((rig.desc().settings.sigma > 0.0).then_some(layout::SMOOTH));
    for id in layers {
        let worst = rig.layer(id).into_iter().find(|v| !(0.0..=1.0).contains(v));
        assert_eq!(worst, None, "{name}: {id:?}");
    }
    let overlay = rig.colours(layout::OVERLAY_LAYER);
    assert!(overlay.as_flattened().iter().all(|v| (0.0..=1.0).contains(v)), "{name}: a line, a shadow or a rim");
    let colours = [rig.colours(layout::PICTURE), rig.colours(layout::TONE_LAYER), rig.picture()].concat();
    assert!(colours.as_flattened().iter().all(|c| (0.0..=1.0).contains(c)), "{name}: a colour");
    assert!(rig.spheres().as_flattened().iter().all(|v| v.is_finite()), "{name}: a sphere");
}

/// Renders a frame, checks that it is finite, and compares with the reference; how many pixels see smoke.
fn check(name: &str, rig: &mut Rig, camera: Camera, light: Light, volume: &Volume) -> usize {
    rig.frame(&scene(Sequence::Restart, camera, light, Some(volume)));
    assert_finite(name, rig);
    let voxel = volume.voxel_size.into_iter().fold(f32::MAX, f32::min);
    let seen = camera.view(rig.desc().size);
    let expected = rig.expected(&seen, &light, voxel).image;
    let differ =
        rig.picture().into_iter().zip(&expected).filter(|(a, e)| (0..4).any(|c| apart(a[c], e[c]) > 1.0 / 255.0));
    let (apart, seen) = (differ.count(), expected.iter().filter(|c| c[3] > 0.0).count());
    // 0.1 % as for any frame; two pixels where so few are seen that this is less.
    assert!(apart <= (seen / 1000).max(2), "{name}: {apart} of {seen} pixels differ");
    seen
}

fn sun() -> Light {
    direction(-1.0, -1.5, -1.0)
}

#[test]
fn pictures_of_odd_sizes() {
    let volume = puffs(20, 0.0);
    for size in [[1, 1], [33, 17], [511, 3], [2, 129], [64, 64]] {
        let settings = Settings { particles: 200, ..Settings::default() };
        let Some(mut rig) = Rig::new(desc(size, [20; 3], settings)) else { return };
        let seen = check(&format!("{size:?}"), &mut rig, camera(0.0), sun(), &volume);
        assert!(seen > 0, "{size:?}");
    }
}

#[test]
fn cameras_anywhere() {
    let volume = puffs(20, 0.0);
    let settings = Settings { particles: 300, ..Settings::default() };
    let Some(mut rig) = Rig::new(desc([90, 70], [20; 3], settings)) else { return };
    let at = |x: f64, y: f64, z: f64| Camera { eye: DVec3::new(x, y, z), near: 0.01, ..camera(0.0) };
    let inside = Camera { target: DVec3::new(0.3, -0.1, -0.25), ..at(-0.35, -0.4, 0.1) };
    check("inside", &mut rig, inside, sun(), &volume);
    let behind = Camera { target: DVec3::new(0.0, 0.0, 9.0), ..at(0.0, 0.0, 4.0) };
    assert_eq!(check("behind", &mut rig, behind, sun(), &volume), 0);
    assert!(check("from above", &mut rig, Camera { up: DVec3::X, ..at(0.0, 5.0, 0.0) }, sun(), &volume) > 500);
    assert!(check("wide", &mut rig, Camera { vertical_fov: 170.0, ..at(0.0, 0.0, 1.2) }, sun(), &volume) > 0);
    assert!(check("narrow", &mut rig, Camera { vertical_fov: 0.01, ..at(0.0, 0.35, 4.0) }, sun(), &volume) > 0);
    assert_eq!(check("too near", &mut rig, Camera { far: 2.0, ..at(0.0, 0.0, 4.0) }, sun(), &volume), 0);
    let beside = Camera { target: DVec3::new(30.0, 0.0, 4.0), ..at(0.0, 0.0, 4.0) };
    assert_eq!(check("beside", &mut rig, beside, sun(), &volume), 0);
}

#[test]
fn worlds_of_any_scale() {
    for scale in [1e-3_f32, 1e4] {
        let mut volume = puffs(20, 0.0);
        volume.voxel_size = volume.voxel_size.map(|h| h * scale);
        volume.origin = volume.origin.map(|o| o * scale);
        let settings = Settings { particles: 200, ..Settings::default() };
        let Some(mut rig) = Rig::new(desc([90, 70], [20; 3], settings)) else { return };
        let s = f64::from(scale);
        let camera = Camera { eye: camera(20.0).eye * s, near: 0.1 * s, far: 100.0 * s, ..camera(20.0) };
        assert!(check(&format!("scale {scale}"), &mut rig, camera, sun(), &volume) > 1000);
    }
}

#[test]
fn volumes_of_any_content() {
    let settings = Settings { particles: 150, ..of_voxels() };
    let Some(mut rig) = Rig::new(desc([70, 60], [24, 24, 24], settings)) else { return };
    let kinds = [1e30, 1e-30, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1.0];
    let make = |n: [u32; 3], density: &dyn Fn(u32, u32, u32) -> f32| {
        let h = n.map(|n| 2.0 / n as f32);
        volume(n, h, [-1.0; 3], density)
    };
    let mixed = make([9, 8, 7], &|x, y, z| kinds[(random(4, x + 9 * (y + 8 * z), 0) * 8.0) as usize]);
    check("mixed", &mut rig, camera(0.0), sun(), &mixed);
    assert!(check("one voxel", &mut rig, camera(0.0), sun(), &make([1; 3], &|_, _, _| 1.0)) > 100);
    assert_eq!(check("no voxel", &mut rig, camera(0.0), sun(), &make([1; 3], &|_, _, _| f32::NAN)), 0);
    assert_eq!(check("empty", &mut rig, camera(0.0), sun(), &make([24; 3], &|_, _, _| 0.1)), 0);
    assert!(check("full", &mut rig, camera(0.0), sun(), &make([24; 3], &|_, _, _| 2.0)) > 1000);
    let flat = volume([20, 20, 8], [0.1, 0.1, 0.25], [-1.0; 3], |x, y, z| if (x + y + z) % 7 == 0 { 0.0 } else { 1.0 });
    assert!(check("flat voxels", &mut rig, camera(0.0), sun(), &flat) > 1000);
}

/// Whatever is allowed of cameras: nothing but what is empty is infinite, of volumes of infinities neither.
#[test]
fn cameras_at_the_ends_of_what_is_allowed() {
    let infinite = volume([12; 3], [0.15; 3], [-0.9; 3], |_, _, _| f32::INFINITY);
    let settings = Settings { particles: 60, sigma: 1.0, ..Settings::default() };
    for shadow in [Shadow::Exact, Shadow::Map] {
        let Some(mut rig) = Rig::new(desc([40, 30], [20; 3], Settings { shadow, ..settings.clone() })) else { return };
        for given in [&infinite, &puffs(20, 0.0)] {
            for (eye, fov) in
                [(4.0, NARROWEST), (4.0, 1e-6), (4.0, 1e-3), (1.5, WIDEST), (FARTHEST.into(), NARROWEST), (1e7, 1e-5)]
            {
                for near in [1e-9, 0.1] {
                    let (eye, far) = (DVec3::new(0.0, 0.0, eye), f64::INFINITY);
                    let camera = Camera { eye, target: DVec3::ZERO, vertical_fov: fov, near, far, ..camera(0.0) };
                    rig.frame(&scene(Sequence::Restart, camera, sun(), Some(given)));
                    assert_finite(&format!("{shadow:?}, {camera:?}"), &mut rig);
                }
            }
        }
    }
}

#[test]
fn backgrounds_that_are_too_bright_are_refused() {
    let settings = Settings { particles: 10, ..Settings::default() };
    let Some(mut rig) = Rig::new(desc([8, 8], [20; 3], settings)) else { return };
    for bad in [1e38, -1.1e6, f32::NAN, f32::INFINITY] {
        rig.offline().set_background([0.0, bad, 0.0, 1.0]);
        let refused = rig.offline().frame(&scene(Sequence::Restart, camera(0.0), sun(), Some(&puffs(20, 0.0))));
        let said = refused.expect_err("it is refused").to_string();
        assert!(said.contains("frame.background") && said.contains("1e6"), "{said}");
    }
}

#[test]
fn no_particles_leave_the_background() {
    let Some(mut rig) = Rig::new(desc([40, 30], [20; 3], Settings { particles: 0, ..Settings::default() })) else {
        return;
    };
    rig.offline().set_background([0.1, 0.2, 0.3, 1.0]);
    rig.frame(&scene(Sequence::Restart, camera(0.0), sun(), Some(&puffs(20, 0.0))));
    assert_eq!(rig.picture(), [[0.1, 0.2, 0.3, 1.0]; 1200]);
}

#[test]
fn one_particle_lies_over_a_backdrop() {
    let settings = Settings { particles: 1, ..Settings::default() };
    let emitter = Some(Emitter { min: [0.0, 0.35, 0.2], max: [0.0, 0.35, 0.2] });
    let Some(mut rig) = Rig::new(desc([40, 30], [20; 3], Settings { emitter, ..settings })) else { return };
    let backdrop: Vec<[f32; 4]> = (0..1200).map(|i| [i as f32 / 1200.0, 0.5, 0.0, 1.0]).collect();
    rig.offline().set_backdrop(&backdrop).expect("a backdrop");
    rig.frame(&scene(Sequence::Restart, camera(0.0), sun(), Some(&puffs(20, 0.0))));
    let (_, id) = rig.pixels();
    let effect = rig.colours(layout::PICTURE);
    let picture = rig.picture();
    let seen = id.iter().filter(|id| **id > 0).count();
    assert!(seen > 10 && seen < 400, "{seen}");
    for pixel in 0..1200 {
        assert_eq!(picture[pixel], if id[pixel] > 0 { effect[pixel] } else { backdrop[pixel] });
    }
}

/// A million spheres of less than a voxel.
#[test]
fn a_million_particles() {
    let n = 48;
    let noise = volume([n; 3], [2.0 / n as f32; 3], [-1.0; 3], |x, y, z| random(6, x + n * (y + n * z), 0) - 0.2);
    let settings = Settings { particles: 1_000_000, fade: 0, ..of_voxels() };
    let Some(mut rig) = Rig::new(desc([48, 32], [n; 3], settings.clone())) else { return };
    rig.frame(&scene(Sequence::Restart, camera(0.0), sun(), Some(&noise)));
    assert_finite("a million", &mut rig);
    let spheres = rig.spheres();
    for (slot, sphere) in spheres.iter().enumerate().step_by(997) {
        let expected = celfx::smoke::reference::grow::radius(
            &noise.grid(),
            settings.threshold,
            [sphere[0], sphere[1], sphere[2]],
            settings.radius,
        );
        assert!((f64::from(sphere[3]) - expected).abs() <= 2.4e-7, "slot {slot}: 2 ulp of 1 m");
    }
    let exact: Vec<[f64; 4]> = spheres.iter().map(|s| s.map(f64::from)).collect();
    let hits = celfx::smoke::reference::render::raycast(&camera(0.0).view([48, 32]), [48, 32], &exact);
    let depth = rig.layer(layout::DEPTH);
    let off = |(hit, depth): &(&Option<_>, &f32)| {
        let z = hit.map_or(f64::INFINITY, |hit: celfx::smoke::reference::render::Hit| hit.depth);
        apart(**depth, z) > 1e-4
    };
    let (apart, seen) = (hits.iter().zip(&depth).filter(off).count(), hits.iter().flatten().count());
    // Silhouettes of a million spheres: a pixel is decided otherwise within 3e-7 m of one.
    assert!(seen > 300 && apart <= 2, "{apart} of {seen}");
}

#[test]
fn lights_anywhere() {
    let volume = puffs(20, 0.0);
    let settings = Settings { particles: 200, shadow: Shadow::Exact, ..Settings::default() };
    let base = desc([70, 60], [20; 3], settings);
    let Some(mut rig) = Rig::new(base.clone()) else { return };
    for way in [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::splat(1e-9), DVec3::new(1e9, -1e9, 3.0)] {
        for (ambient, fill, up) in [(0.0, 0.0, DVec3::Y), (1.0, 0.5, DVec3::Y), (0.0, 1.0, DVec3::new(1e-3, 0.0, -1e9))]
        {
            let light = Light { source: LightSource::Direction(way), ambient, fill, up, ..Light::default() };
            assert!(check(&format!("{light:?}"), &mut rig, camera(0.0), light, &volume) > 500);
        }
    }
    drop(rig);
    let Some(mut rig) = Rig::new(Desc { point_light: true, ..base }) else { return };
    for place in [DVec3::ZERO, DVec3::new(0.3, -0.1, -0.25), DVec3::new(0.0, 0.0, 4.0), DVec3::new(1e3, 1e3, -1e3)] {
        let light = Light { source: LightSource::Position(place), ambient: 0.2, ..Light::default() };
        check(&format!("{light:?}"), &mut rig, camera(0.0), light, &volume);
    }
}

#[test]
fn velocities_that_throw_everything_out() {
    let mut volume = moving_puffs(20, 0.0);
    let fast = volume.velocity.iter_mut().flatten().enumerate();
    fast.for_each(|(i, v)| *v = [[1e30, 0.0, 0.0], [f32::MAX, f32::MIN, 0.0], [0.0, 40.0, 0.0]][i % 3]);
    let settings = Settings { particles: 200, ..Settings::default() };
    let Some(mut rig) = Rig::new(Desc { velocity: true, ..desc([60, 50], [20; 3], settings) }) else { return };
    for i in 0..10 {
        let sequence = if i == 0 { Sequence::Restart } else { Sequence::Advance };
        rig.frame(&scene(sequence, camera(0.0), sun(), Some(&volume)));
        assert_finite(&format!("frame {i}"), &mut rig);
    }
}
