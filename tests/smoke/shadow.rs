//! Shadows against the reference in f64, and the shadow map against the exact ones.

use celfx::low_level::smoke::layout;
use celfx::smoke::reference::{render, shadow};
use celfx::smoke::settings::Shadow;
use celfx::smoke::{Desc, Settings};
use celfx::view::{Camera, Light};
use glam::DVec3;

use crate::common::bench::{Bench, Given};
use crate::common::scenes::{camera, desc, direction, point};
use crate::spheres::{WRITTEN, cluster, exact, place, render};

const SIZE: [u32; 2] = [120, 90];

fn effect(particles: u32, shadow: Shadow, softness: f32, point_light: bool) -> Desc {
    let settings = Settings { particles, fade: 0, sigma: 0.0, shadow, softness, ..Settings::default() };
    Desc { point_light, ..desc(SIZE, [4; 3], settings) }
}

/// The layer `shadow`, and the depth that says where two images see the same.
fn shadows(bench: &mut Bench) -> Vec<f32> {
    bench.read(layout::SHADOW, (SIZE[0] * SIZE[1]) as usize)
}

/// Pixels whose light differs from the reference's by more than `bound`, of those that see something.
fn differing(bench: &mut Bench, camera: Camera, light: Light, spheres: &[[f32; 4]], bound: f64) -> [usize; 3] {
    render(bench, camera, light, spheres);
    let actual = shadows(bench);
    let spheres = exact(spheres);
    let hits = render::raycast(&camera.view(SIZE), SIZE, &spheres);
    let softness = f64::from(bench.desc.settings.softness);
    let expected = shadow::shadow(&camera.view(SIZE), SIZE, &spheres, &hits, light.source, softness);
    let seen = || (0..hits.len()).filter(|pixel| hits[*pixel].is_some());
    assert!(actual.iter().all(|s| (0.0..=1.0).contains(s)));
    let apart = seen().filter(|pixel| (f64::from(actual[*pixel]) - expected[*pixel]).abs() > bound).count();
    let dark = seen().filter(|pixel| expected[*pixel] < 0.5).count();
    [apart, dark, seen().count()]
}

fn assert_exact(name: &str, light: Light, point_light: bool, softness: f32) {
    let Some(mut bench) = Bench::new(effect(500, Shadow::Exact, softness, point_light)) else { return };
    let mut total = [0; 3];
    for (key, radius) in [(1, 0.04), (2, 0.12), (3, 0.4)] {
        for degrees in [0.0, 100.0, 215.0] {
            // Soft: a near miss at a distance t is 3e-7 / (k t) off; 1e-3 covers t > 0.003 at k = 0.1.
            let bound = if softness > 0.0 { 1e-3 } else { 0.5 };
            let counts = differing(&mut bench, camera(degrees), light, &cluster(key, 500, radius), bound);
            (0..3).for_each(|i| total[i] += counts[i]);
        }
    }
    let [apart, dark, seen] = total;
    println!("{name}, softness {softness}: {apart} of {seen} pixels differ, {dark} in shadow");
    assert!(dark * 20 > seen && dark < seen, "{name}: the test shows nothing");
    // Borders of shadows, and of spheres: the same pixel sees another point. Rounding moves both by some 3e-7 m, a
    // hundred-thousandth of a pixel; contacts of spheres, where t is tiny, are the softer share.
    assert!(apart * 1000 <= seen, "{name}, softness {softness}: {apart} of {seen}");
}

#[test]
fn exact_shadows_of_a_directional_light() {
    for softness in [0.0, 0.1, 0.7] {
        assert_exact("directional", direction(-1.0, -1.5, -1.0), false, softness);
        assert_exact("along an axis", direction(0.0, -1.0, 0.0), false, softness);
    }
}

#[test]
fn exact_shadows_of_a_point_light() {
    for softness in [0.0, 0.1, 0.7] {
        assert_exact("point outside", point(2.0, 2.5, 1.0), true, softness);
        assert_exact("point inside", point(0.1, 0.3, -0.2), true, softness);
    }
}

/// The ray to the light may meet more spheres than one dispatch works on.
#[test]
fn lists_longer_than_the_loop_budget_go_on() {
    let count = 90_000;
    let Some(mut bench) = Bench::new(effect(count, Shadow::Exact, 0.0, false)) else { return };
    assert!(bench.layout.luminance_parts > 2);
    // Ahead of everything a layer of spheres that the light passes beside, then one that it meets: the last in order.
    let mut spheres: Vec<[f32; 4]> = vec![[0.5, 0.0, 0.0, 0.45]; count as usize];
    spheres[0] = [-0.5, 0.0, 0.0, 0.4];
    spheres[count as usize - 1] = [-0.5, 0.8, 0.0, 0.2];
    let (camera, light) = (camera(0.0), direction(0.0, -1.0, 0.0));
    render(&mut bench, camera, light, &spheres);
    let actual = shadows(&mut bench);
    // The reference with one sphere for the ninety thousand that are equal.
    let few: Vec<[f64; 4]> = exact(&[spheres[0], spheres[1], spheres[count as usize - 1]]);
    let hits = render::raycast(&camera.view(SIZE), SIZE, &few);
    let expected = shadow::shadow(&camera.view(SIZE), SIZE, &few, &hits, light.source, 0.0);
    // Not on the many: whichever of them is seen, the others shadow it.
    let pixels = || hits.iter().enumerate().filter(|(_, hit)| hit.is_some_and(|h| h.sphere != 1));
    let apart = pixels().filter(|(pixel, _)| (f64::from(actual[*pixel]) - expected[*pixel]).abs() > 0.5).count();
    let dark = pixels().filter(|(pixel, _)| expected[*pixel] == 0.0).count();
    assert!(dark > 20 && apart <= 1, "{apart} of {} differ, {dark} dark", pixels().count());
    // With a cone as wide as this, every sphere is in the one tile of level 0: no list is longer.
    drop(bench);
    let Some(mut bench) = Bench::new(effect(45_000, Shadow::Exact, 1.0, false)) else { return };
    let mut spheres = cluster(5, 45_000, 0.004);
    spheres.iter_mut().for_each(|s| s[3] *= 0.3);
    spheres[44_999] = [0.0, 0.0, 0.0, 0.5];
    bench.write(layout::SPHERES, &spheres);
    bench.run(&Given { camera, light, volume: &place(), frames: 0, rendered: true, omit: WRITTEN });
    let actual = shadows(&mut bench);
    let spheres = exact(&spheres);
    let hits = render::raycast(&camera.view(SIZE), SIZE, &spheres);
    let some: Vec<_> = hits.iter().enumerate().map(|(i, hit)| hit.filter(|_| i % 13 == 0)).collect();
    let expected = shadow::shadow(&camera.view(SIZE), SIZE, &spheres, &some, light.source, 1.0);
    let seen = some.iter().flatten().count();
    let close = |pixel: &usize| (f64::from(actual[*pixel]) - expected[*pixel]).abs() <= 1e-3;
    let apart = (0..some.len()).filter(|pixel| some[*pixel].is_some() && !close(pixel)).count();
    // As in `assert_exact`, of few pixels.
    assert!(seen > 100 && apart <= 1, "{apart} of {seen} differ");
}

#[test]
fn a_shadow_map_roughly_agrees() {
    for (point_light, light) in [(false, direction(-1.0, -1.5, -1.0)), (true, point(2.0, 2.5, 1.0))] {
        let spheres = cluster(2, 300, 0.2);
        let image = |kind| {
            let mut bench = Bench::new(effect(300, kind, 0.0, point_light))?;
            render(&mut bench, camera(40.0), light, &spheres);
            Some((shadows(&mut bench), crate::spheres::pixels(&mut bench).0))
        };
        let (Some(exact), Some(map)) = (image(Shadow::Exact), image(Shadow::Map)) else { return };
        let seen = exact.1.iter().filter(|y| **y > 0.0).count();
        // Luminance: what faces away is dark in either way.
        let apart = exact.1.iter().zip(&map.1).filter(|(a, b)| (**a - **b).abs() > 0.1).count();
        println!("point light: {point_light}: {apart} of {seen} pixels differ by more than 0.1");
        // Borders of shadows a few pixels long, softened by three taps, and what the bias lets through at contacts.
        assert!(apart * 20 <= seen, "point light: {point_light}: {apart} of {seen}");
    }
}

#[test]
fn a_lit_sphere_has_no_acne() {
    for (point_light, light) in [(false, direction(-0.3, -0.6, -1.0)), (true, point(1.0, 1.5, 2.5))] {
        for (kind, taps) in [(Shadow::Map, 1), (Shadow::Map, 3), (Shadow::Map, 5), (Shadow::Exact, 3)] {
            let mut desc = effect(2, kind, 0.0, point_light);
            desc.settings.shadow_filter = taps;
            let Some(mut bench) = Bench::new(desc) else { return };
            // The other one only widens what the map covers.
            render(&mut bench, camera(0.0), light, &[[0.1, -0.2, 0.0, 0.6], [-0.95, -0.95, -0.95, 0.02]]);
            let luminance = crate::spheres::pixels(&mut bench).0;
            let hits = render::raycast(
                &camera(0.0).view(SIZE),
                SIZE,
                &[[0.1, -0.2, 0.0, 0.6]].map(|s: [f32; 4]| s.map(f64::from)),
            );
            let lit = vec![1.0; hits.len()];
            let spheres = [[0.1_f32, -0.2, 0.0, 0.6].map(f64::from)];
            let of = |light| render::luminance(&camera(0.0).view(SIZE), SIZE, &spheres, &hits, light, &lit);
            let (expected, direct) = (of(&light), of(&Light { fill: 0.0, ..light }));
            let lit = (0..hits.len()).filter(|i| hits[*i].is_some() && direct[*i] > 0.25 + 0.75 * 0.1);
            let dark = lit.clone().filter(|i| luminance[*i] < expected[*i] - 1e-3).count();
            assert!(lit.count() > 800);
            assert_eq!(dark, 0, "{kind:?}, {taps} taps, point light: {point_light}");
        }
    }
}

#[test]
fn light_in_a_sphere_and_a_sphere_around_everything() {
    let Some(mut bench) = Bench::new(effect(40, Shadow::Exact, 0.0, true)) else { return };
    let mut spheres = cluster(9, 40, 0.2);
    spheres[7] = [0.4, 0.4, 0.4, 0.3];
    // The light inside sphere 7: all but its own surface is dark.
    let [apart, dark, seen] = differing(&mut bench, camera(0.0), point(0.45, 0.4, 0.4), &spheres, 0.5);
    assert!(apart * 1000 <= seen && dark > seen / 2, "{apart} of {seen}, {dark} dark");
    // The camera inside of a sphere that shadows everything in it from a light outside.
    spheres[7] = [0.0, 0.0, 0.0, 30.0];
    let light = point(100.0, 20.0, 3.0);
    let [apart, dark, seen] = differing(&mut bench, camera(0.0), light, &spheres, 0.5);
    assert!(apart == 0 && dark == seen && seen > 500, "{apart} of {seen}, {dark} dark");
    let eye = Camera { eye: DVec3::new(0.0, 0.0, 50.0), ..camera(0.0) };
    let [apart, _, seen] = differing(&mut bench, eye, light, &spheres, 0.5);
    assert!(apart * 1000 <= seen && seen > 5000, "{apart} of {seen}");
}
