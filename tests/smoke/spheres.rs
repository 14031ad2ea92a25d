//! What pixels see: depth, group and luminance.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::smoke::Settings;
use celfx::smoke::reference::render::{self, Hit};
use celfx::smoke::settings::{Mask, Shadow};
use celfx::view::{Camera, Light, LightSource, SecondLight};
use glam::DVec3;

use crate::common::apart;
use crate::common::bench::{Bench, Given};
use crate::common::scenes::{camera, desc, direction, point, random, volume};
use crate::common::unpacked;

/// Spheres are the test's own.
pub const WRITTEN: &[&str] = &["smoke.restart", "smoke.advect", "smoke.grow"];

/// A volume from -1 to 1, which spheres may be in.
pub fn place() -> Volume {
    volume([4; 3], [0.5; 3], [-1.0; 3], |_, _, _| 1.0)
}

/// Renders spheres.
pub fn render(bench: &mut Bench, camera: Camera, light: Light, spheres: &[[f32; 4]]) {
    bench.write(layout::SPHERES, spheres);
    bench.run(&Given { camera, light, volume: &place(), frames: 0, rendered: true, omit: WRITTEN });
}

pub fn exact(spheres: &[[f32; 4]]) -> Vec<[f64; 4]> {
    spheres.iter().map(|s| s.map(f64::from)).collect()
}

pub fn pixels(bench: &mut Bench) -> (Vec<f64>, Vec<u32>) {
    let count = (bench.desc.size[0] * bench.desc.size[1]) as usize;
    unpacked(&bench.read(layout::PIXELS, count))
}

pub fn depth(bench: &mut Bench) -> Vec<f32> {
    let count = (bench.desc.size[0] * bench.desc.size[1]) as usize;
    bench.read(layout::DEPTH, count)
}

/// Some spheres, in and around the box from -1 to 1.
pub fn cluster(key: u32, count: u32, radius: f32) -> Vec<[f32; 4]> {
    (0..count)
        .map(|i| {
            let p = [0, 1, 2].map(|a| 2.0 * random(key, i, a) - 1.0);
            [p[0], p[1], p[2], radius * (0.2 + random(key, i, 3))]
        })
        .collect()
}

/// Depth and luminance of one sphere of a camera at the origin that looks along -z, by the quadratic formula.
fn one_sphere(camera: &Camera, light: &Light, size: [u32; 2], sphere: [f32; 4], x: u32, y: u32) -> Option<[f64; 3]> {
    let half = camera.half_extent(size);
    let across = |i: u32, n: u32| (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0;
    let ray = DVec3::new(across(x, size[0]) * half.x, -across(y, size[1]) * half.y, -1.0);
    let [cx, cy, cz, r] = sphere.map(f64::from);
    let centre = DVec3::new(cx, cy, cz) - camera.eye;
    let (a, b, c) = (ray.length_squared(), ray.dot(centre), centre.length_squared() - r * r);
    let root = (b * b - a * c).sqrt();
    let depth = (b - root) / a;
    let normal = (ray * depth - centre) / r;
    let towards = |source| match source {
        LightSource::Direction(d) => -d.normalize(),
        LightSource::Position(p) => (p - camera.eye - ray * depth).normalize(),
    };
    // Cosine between the normal and the way to the eye.
    let facing = -normal.dot(ray) / a.sqrt();
    let first = normal.dot(towards(light.source));
    let luminance = light.luminance(first, 1.0, normal.dot(light.up.normalize()));
    let second = light.second.map_or(0.0, |second| normal.dot(towards(second.source)));
    let luminance = light.with_second(luminance, second);
    (root > 0.0 && depth >= camera.near).then_some([depth, luminance, facing])
}

#[test]
fn one_sphere_has_its_closed_form() {
    let size = [101, 80];
    let at = |source| Some(SecondLight { source, strength: 0.4 });
    let above = at(LightSource::Direction(DVec3::new(0.5, -2.0, -0.1)));
    for (point_light, light) in [
        (false, direction(-0.4, -0.7, -1.0)),
        (true, point(1.5, 2.0, 1.0)),
        (false, Light { second: above, ..direction(-0.4, -0.7, -1.0) }),
        (true, Light { second: at(LightSource::Position(DVec3::ONE)), ..point(1.5, 2.0, 1.0) }),
    ] {
        let settings = Settings { particles: 1, fade: 0, sigma: 0.0, shadow: Shadow::None, ..Settings::default() };
        let mut desc = desc(size, [4; 3], settings);
        desc.point_light = point_light;
        desc.second_light = light.second.is_some();
        let Some(mut bench) = Bench::new(desc) else { return };
        let (mut worst, mut seen, mut borders) = ([0.0_f64; 2], 0, 0);
        let far_away = Camera { eye: DVec3::new(1e4, 0.0, 1e4), target: DVec3::new(1e4, 0.0, 0.0), ..camera(0.0) };
        for (eye, sphere) in [
            (DVec3::ZERO, [0.0, 0.0, -3.0, 0.8]),
            (DVec3::ZERO, [0.7, -0.3, -2.0, 0.5]),
            (DVec3::ZERO, [0.9, 0.2, -1.0, 0.95]),
            (DVec3::ZERO, [0.0, 0.0, -100.0, 20.0]),
            (DVec3::new(0.3, 0.2, 5.0), [0.3, 0.2, 4.0, 1e-2]),
            (far_away.eye, [1e4, 0.5, 9_995.0, 1.0]),
        ] {
            let camera = Camera { eye, target: eye - DVec3::Z, near: 0.01, far: 1e3, ..camera(0.0) };
            render(&mut bench, camera, light, &[sphere]);
            let (luminance, id) = pixels(&mut bench);
            let depth = depth(&mut bench);
            for pixel in 0..depth.len() {
                let [x, y] = [pixel as u32 % size[0], pixel as u32 / size[0]];
                let expected = one_sphere(&camera, &light, size, sphere, x, y);
                // Towards the silhouette the root of what is inside has no bounded derivative: an error e of the
                // distance beside the centre makes e / facing of depth and normal. Few pixels are so near to it.
                if expected.is_some_and(|e| e[2] < 0.05) || expected.is_some() != (id[pixel] > 0) {
                    borders += 1;
                    continue;
                }
                let Some([z, y, _]) = expected else { continue };
                seen += 1;
                worst[0] = worst[0].max(apart(depth[pixel], z) / z);
                worst[1] = worst[1].max((luminance[pixel] - y).abs() / y);
            }
        }
        println!("depth {:.1e}, luminance {:.1e} in {seen} pixels, {borders} on borders", worst[0], worst[1]);
        // The bound of the specification.
        assert!(worst[0] <= 1e-5 && worst[1] <= 1e-5, "{worst:?}");
        // A share of 0.00125 of the radius, some 2 pi 20 * 0.025 pixels a sphere.
        assert!(seen > 5000 && borders * 100 < seen, "{seen} seen, {borders} borders");
    }
}

fn assert_seen(name: &str, bench: &mut Bench, camera: Camera, spheres: &[[f32; 4]], least: usize) {
    let light = direction(-1.0, -1.0, -1.0);
    let size = bench.desc.size;
    render(bench, camera, light, spheres);
    let (_, id) = pixels(bench);
    let depth = depth(bench);
    let groups: Vec<u32> = bench.read(layout::GROUPS, spheres.len());
    let hits: Vec<Option<Hit>> = render::raycast(&camera.view(size), size, &exact(spheres));
    let (mut differing, mut worst) = (0, 0.0_f64);
    for (pixel, hit) in hits.iter().enumerate() {
        assert_eq!(id[pixel] == 0, depth[pixel] == f32::INFINITY, "{name}: depth and group disagree at {pixel}");
        let z = hit.map_or(f64::INFINITY, |hit| hit.depth);
        let expected = hit.map_or(0, |hit| groups[hit.sphere]);
        let scale = hit.map_or(1.0, |hit| hit.depth.max(spheres[hit.sphere][3].into()));
        let apart = apart(depth[pixel], z) / scale;
        // At a silhouette the depth is off by up to sqrt(2 * 3e-7) of the radius: 8e-4, in the nearest pixel of many.
        if id[pixel] != expected || apart > 1e-4 {
            differing += 1;
        } else {
            worst = worst.max(apart);
        }
    }
    let seen = hits.iter().flatten().count();
    println!("{name}: {differing} of {seen} pixels differ, depth elsewhere by {worst:.1e}");
    assert!(seen >= least, "{name}: {seen} pixels seen");
    // Silhouettes and lines where two spheres meet: a pixel is decided otherwise within 3e-7 of them.
    assert!(differing * 2000 <= seen, "{name}: {differing} of {seen}");
}

#[test]
fn groups_and_depth_are_those_of_ray_casting() {
    let flat = Settings { sigma: 0.0, shadow: Shadow::None, mask: Mask::Groups, ..Settings::default() };
    let settings = Settings { particles: 900, fade: 0, ..flat };
    let Some(mut bench) = Bench::new(desc([199, 150], [4; 3], settings)) else { return };
    let inside =
        Camera { eye: DVec3::new(0.1, 0.0, 0.2), target: DVec3::X, near: 0.01, vertical_fov: 80.0, ..camera(0.0) };
    let behind = Camera { eye: DVec3::new(0.0, 0.0, 4.0), target: DVec3::new(0.0, 0.0, 9.0), ..camera(0.0) };
    let wide = Camera { eye: DVec3::new(0.0, 0.0, 1.4), vertical_fov: 150.0, near: 1e-3, ..camera(0.0) };
    let sliced = Camera { near: 3.6, far: 4.2, ..camera(30.0) };
    let endless = Camera { far: f64::INFINITY, ..camera(77.0) };
    for (key, radius) in [(1, 0.05), (2, 0.3), (3, 1.0)] {
        let spheres = cluster(key, 900, radius);
        let check = &mut |name: &str, camera, least| {
            assert_seen(&format!("{name}, radius {radius}"), &mut bench, camera, &spheres, least);
        };
        check("outside", camera(20.0), 5000);
        check("inside", inside, if radius < 0.2 { 2000 } else { 0 });
        check("behind", behind, 0);
        check("wide", wide, 100);
        check("sliced", sliced, 1000);
        check("endless", endless, 5000);
    }
}
