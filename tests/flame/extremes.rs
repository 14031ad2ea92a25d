//! What is at the ends of what is allowed: everything stays finite, and agrees with the reference or with what can only be.

use celfx::data::Particles;
use celfx::flame::settings::{Colour, Mode, Sampling};
use celfx::flame::{Desc, Settings};
use celfx::view::{Camera, FARTHEST, NARROWEST, WIDEST};
use glam::DVec3;

use crate::common::flame::{FlameRig, ball, desc, particles};
use crate::common::scenes::{camera, random};
use crate::oracle::{Shot, Tally, assert_finite, check, control, light, sums};

/// The specification's: of all samples, so many may differ.
const SHARE: f64 = 1e-5;
const SIZE: [u32; 2] = [48, 36];

fn base() -> Settings {
    Settings { repetitions: 16, count: 6.0, spread: Some(0.15), size: Some(0.3), ..Settings::paper() }
}

/// Looks along -z from the origin, 90 degrees high.
fn ahead() -> Camera {
    Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, ..Camera::default() }
}

/// Compares a frame with the reference and sees that it is finite.
fn agrees(name: &str, desc: &Desc, shot: &Shot) -> Option<Tally> {
    let mut rig = FlameRig::new(desc.clone())?;
    let tally = check(name, &mut rig, shot);
    assert_finite(name, &mut rig);
    Some(tally)
}

#[test]
fn thresholds() {
    let given = ball(60, 1);
    let above = 1.0 + f32::EPSILON;
    let mut total = Tally::default();
    for threshold in [f32::MIN, 0.0, f32::from_bits(1), 1.0 - f32::EPSILON / 2.0, above, f32::MAX] {
        let desc = desc(SIZE, 60, Settings { threshold, ..base() });
        let Some(tally) = agrees(&format!("{threshold:e}"), &desc, &Shot::new(&given, camera(0.0))) else { return };
        assert_eq!(tally.hits == 0, threshold > 1.0, "{threshold}: {tally:?}");
        total.add(tally);
    }
    // Without alpha: only what asks for none is passed.
    for threshold in [-1.0, 0.0, f32::from_bits(1)] {
        let desc = desc(SIZE, 60, Settings { threshold, alpha_scale: 0.0, ..base() });
        let Some(tally) = agrees("no alpha", &desc, &Shot::new(&given, camera(0.0))) else { return };
        assert_eq!(tally.hits == 0, threshold > 0.0, "{threshold}: {tally:?}");
        total.add(tally);
    }
    let desc = desc(SIZE, 60, Settings { alpha_scale: 1e6, threshold: 1.0, ..base() });
    let Some(tally) = agrees("much alpha", &desc, &Shot::new(&given, camera(0.0))) else { return };
    total.add(tally);
    total.assert_few("thresholds", SHARE);
}

#[test]
fn temperatures() {
    let kelvins = [0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e-40, 1.0, 199.0, 699.9, 700.0, 800.0];
    let kelvins = [&kelvins[..], &[3000.0, 3000.1, 1e5, f32::MAX]].concat();
    let place = |i: usize| [-1.5 + 0.2 * i as f32, 0.3 * (i % 3) as f32 - 0.3, 0.0];
    let mut rows: Vec<[f32; 4]> = kelvins.iter().zip(0..).map(|(t, i)| [place(i)[0], place(i)[1], 0.0, *t]).collect();
    // Places that are none.
    for (axis, x) in [(0, f32::NAN), (1, f32::INFINITY), (2, f32::NEG_INFINITY)] {
        let mut row = [0.0, 0.0, 0.0, 3000.0];
        row[axis] = x;
        rows.push(row);
    }
    rows.push([0.0, 0.0, 0.5, 2500.0]);
    let given = particles(&rows);
    let mut total = Tally::default();
    let ramp = Colour::Ramp(vec![[0.1, 0.2, 0.9], [1.0, 0.5, 0.0]]);
    let (displayable, physical) = (Colour::Displayable, Colour::Physical);
    for (hottest, colours) in
        [(800.0, vec![physical.clone()]), (3000.0, vec![displayable, ramp]), (1e5, vec![physical])]
    {
        for colour in colours {
            // Everything that has a temperature passes, if it has any alpha.
            let settings = Settings { threshold: 1e-3, count: 9.0, colour, ..base() };
            let desc = Desc { hottest, ..desc(SIZE, rows.len() as u32, settings) };
            let Some(mut rig) = FlameRig::new(desc) else { return };
            let name = format!("{hottest} K");
            total.add(check(&name, &mut rig, &Shot::new(&given, camera(0.0))));
            assert_finite(&name, &mut rig);
            let prepared = rig.prepared();
            let dropped: Vec<usize> = (0..rows.len()).filter(|row| prepared[*row].count == 0).collect();
            // Not above 0 K, or not finite; 1e-40 and 1 K, which have no render particles; places that are none.
            assert_eq!(dropped, [0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18], "{name}");
        }
    }
    total.assert_few("temperatures", SHARE);
}

/// Render particles in the same place: the smaller id wins, then the first row, whatever the order.
#[test]
fn ties() {
    let ramp = Colour::Ramp(vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let settings = Settings { spread: Some(0.0), threshold: 0.0, size: Some(100.0), colour: ramp, ..base() };
    let rows: Vec<[f32; 4]> = (0..300).map(|i| [0.0, 0.0, -2.0, 800.0 + 7.0 * i as f32]).collect();
    let positions = particles(&rows);
    let orders: [Vec<u32>; 4] = [
        (0..300).collect(),
        (0..300).rev().collect(),
        (0..300).map(|i| i * 77 % 300).collect(),
        (0..300).map(|i| i / 150 + 9).collect(),
    ];
    for ids in orders {
        let first = (0..300).min_by_key(|row| (ids[*row], *row)).expect("a row");
        let given = Particles { id: Some(ids), ..positions.clone() };
        let Some(mut rig) = FlameRig::new(desc([16, 16], 300, settings.clone())) else { return };
        let tally = check("ties", &mut rig, &Shot::new(&given, ahead()));
        let (sums, winner) = (sums(&mut rig, 16), light(&rig.prepared()[first]));
        assert_eq!((tally.hits, tally.differing), (16 * 16 * 16, 0), "each pixel, each time");
        for light in sums.light {
            assert_eq!(light, winner.map(|c| 16 * u64::from(c)), "{first}");
        }
    }
}

#[test]
fn sizes_and_counts() {
    let given = ball(60, 1);
    let mut total = Tally::default();
    let huge = Settings { size: Some(50.0), ..base() };
    let wide = Settings { size: None, size_pixels: Some(16384.0), ..base() };
    let everywhere = Settings { spread: Some(30.0), size: Some(3.0), count: 50.0, ..base() };
    let atoms = Settings { size: Some(1e-6), count: 200.0, ..base() };
    let once = Settings { variants: 1, repetitions: 1, ..base() };
    let varied = Settings { variants: 64, ..base() };
    let rare = Settings { count: 0.3, ..base() };
    for (name, settings) in [
        ("huge", huge),
        ("wide", wide),
        ("everywhere", everywhere),
        ("atoms", atoms),
        ("once", once),
        ("varied", varied),
        ("rare", rare),
    ] {
        let Some(tally) = agrees(name, &desc(SIZE, 60, settings), &Shot::new(&given, camera(0.0))) else { return };
        total.add(tally);
    }
    for settings in [
        Settings { size: Some(0.0), ..base() },
        Settings { size: None, size_pixels: Some(0.0), ..base() },
        Settings { count: 0.0, ..base() },
    ] {
        let Some(tally) = agrees("none", &desc(SIZE, 60, settings), &Shot::new(&given, camera(0.0))) else { return };
        assert_eq!(tally.hits, 0);
    }
    total.assert_few("sizes and counts", SHARE);
}

#[test]
fn pictures_of_odd_sizes() {
    let given = ball(60, 1);
    let mut total = Tally::default();
    for size in [[1, 1], [17, 3], [33, 65], [2, 129], [257, 1], [16, 16]] {
        let settings = Settings { sampling: Sampling::ShuffledSobol, ..base() };
        let desc = desc(size, 60, settings);
        let Some(tally) = agrees(&format!("{size:?}"), &desc, &Shot::new(&given, camera(0.0))) else { return };
        assert!(tally.hits > 0, "{size:?}");
        total.add(tally);
    }
    total.assert_few("odd sizes", SHARE);
}

#[test]
fn cameras_anywhere() {
    let given = ball(60, 1);
    let [x, y, z] = given.position[3].map(f64::from);
    let middle = DVec3::new(x, y, z);
    let at = |eye: DVec3| Camera { eye, target: eye - DVec3::new(0.3, 0.2, 1.0), near: 1e-3, ..camera(0.0) };
    let mut total = Tally::default();
    let Some(mut rig) = FlameRig::new(desc(SIZE, 60, Settings { spread: Some(0.3), ..base() })) else { return };
    for (name, camera) in [
        ("in a particle's middle", at(middle)),
        ("in its ball", at(middle + DVec3::new(0.05, 0.02, 0.1))),
        ("behind all", at(DVec3::new(0.0, 0.0, -3.0))),
        ("wide", Camera { vertical_fov: 179.0, ..at(DVec3::new(0.2, 0.0, 1.1)) }),
        ("narrow", Camera { vertical_fov: 0.01, target: middle, ..camera(0.0) }),
        ("thin", Camera { near: 4.0, far: 4.0001, ..camera(0.0) }),
        ("from above", Camera { up: DVec3::X, target: DVec3::ZERO, ..at(DVec3::new(0.0, 4.0, 0.0)) }),
    ] {
        total.add(check(name, &mut rig, &Shot::new(&given, camera)));
        assert_finite(name, &mut rig);
    }
    total.assert_few("cameras", SHARE);
}

/// Whatever is allowed of cameras and particles: nothing but what is empty is infinite.
#[test]
fn cameras_and_particles_at_the_ends_of_what_is_allowed() {
    let far = FARTHEST;
    let mut rows: Vec<[f32; 4]> = vec![[0.0, 0.0, 0.0, 3e3], [far, 0.0, 0.0, 3e3], [0.0, -far, far, f32::MAX]];
    rows.extend([[f32::MAX, 0.0, 0.0, 3e3], [1e-38, 1e-45, 0.0, 1e6], [0.1, 0.0, 0.1, f32::MIN_POSITIVE]]);
    let given = particles(&rows);
    for colour in [Colour::Physical, Colour::Displayable, Colour::Ramp(vec![[1e6; 3], [0.0, 1e6, 1e6]])] {
        let settings = Settings { colour, hottest: 700.0, intensity: 1e6, light: 1e6, ..base() };
        for mode in [Mode::Stochastic, Mode::Expected] {
            let hottest = 1e6;
            let desc = Desc { hottest, ..desc([24, 18], 6, Settings { mode, ..settings.clone() }) };
            let Some(mut rig) = FlameRig::new(desc) else { return };
            for (eye, fov) in [(4.0, NARROWEST), (4.0, 1e-3), (1e3, WIDEST), (FARTHEST.into(), NARROWEST), (1e-6, 90.0)]
            {
                for near in [1e-9, 1.0] {
                    let (eye, far) = (DVec3::new(0.0, 0.0, eye), f64::INFINITY);
                    let camera = Camera { eye, target: DVec3::ZERO, vertical_fov: fov, near, far, ..camera(0.0) };
                    rig.frame(&given, camera);
                    assert_finite(&format!("{mode:?}, {camera:?}"), &mut rig);
                    assert!(rig.effect().as_flattened().iter().all(|c| c.is_finite()), "{mode:?}, {camera:?}");
                }
            }
        }
    }
}

/// A sprite that covers the picture and always passes.
fn opaque() -> Settings {
    Settings { spread: Some(0.0), size: Some(100.0), threshold: 0.0, count: 1.0, ..Settings::paper() }
}

/// Sums above 2^32, squares above 2^48; and as many turns of a dispatch's outer loop as there can be.
#[test]
fn many_repetitions() {
    let given = particles(&[[0.0, 0.0, -2.0, 3000.0]]);
    let repetitions = 100_000;
    let Some(mut rig) = FlameRig::new(desc([8, 8], 1, Settings { repetitions, ..opaque() })) else { return };
    rig.frame(&given, ahead());
    assert_finite("many repetitions", &mut rig);
    let at_once = control(&mut rig).part_repetitions;
    println!("{at_once} repetitions a dispatch");
    let (sums, n) = (sums(&mut rig, repetitions), u64::from(repetitions));
    let light = light(&rig.prepared()[0]).map(u64::from);
    assert_eq!(light, [65535; 3], "the hottest is white");
    for pixel in 0..64 {
        assert_eq!(sums.hits[pixel], repetitions);
        assert_eq!((sums.light[pixel], sums.squares[pixel]), (light.map(|c| n * c), light.map(|c| n * c * c)));
    }
    // White within the colour table's 1e-4; all of it is covered, and no repetition differs from another.
    for (mean, variance) in rig.mean().iter().zip(rig.variance()) {
        assert!(mean.iter().all(|c| (c - 1.0).abs() < 1e-4) && mean[3] == 1.0, "{mean:?}");
        assert_eq!(variance, [0.0, 0.0, 0.0, repetitions as f32]);
    }
    // 100,000 additions of a float, each of half an ulp.
    assert!(rig.nearest().iter().all(|z| (z - 2.0).abs() < 2.0 * 1e5 * 6e-8), "{:?}", rig.nearest()[0]);
}

/// As many particles in one place as a few seconds allow. The one that wins is the last of them.
#[test]
fn many_particles_in_one_pixel() {
    for count in [1000_u32, 30_000, 100_000] {
        let mut rows = vec![[0.0, 0.0, -2.0, 2000.0]; count as usize];
        rows[count as usize - 1][3] = 3000.0;
        let given = Particles { id: Some((0..count).rev().collect()), ..particles(&rows) };
        let settings = Settings { repetitions: 1, count: 1.5, ..opaque() };
        let Some(mut rig) = FlameRig::new(desc([8, 8], count, settings)) else { return };
        rig.frame(&given, ahead());
        let segments = control(&mut rig).segments;
        assert_eq!(segments > 1, count > 1000, "{count}: {segments} segments");
        let sums = sums(&mut rig, 1);
        assert_eq!((&sums.hits[..], &sums.light[..]), (&[1; 64][..], &[[65535; 3]; 64][..]), "{count}");
    }
}

/// Many small ones side by side in one tile, whose list is cut into segments.
#[test]
fn a_tile_with_a_long_list() {
    let spots: Vec<[f32; 4]> = (0..60_000)
        .map(|i| {
            let [x, y, z, t] = [0, 1, 2, 3].map(|d| random(5, i, d));
            [0.9 * (2.0 * x - 1.0), 0.9 * (2.0 * y - 1.0), -1.0 - z, 800.0 + 2000.0 * t]
        })
        .collect();
    let given = particles(&spots);
    // A few of 60,000 in each pixel, most of which fail.
    let settings = Settings { spread: Some(0.01), size: Some(0.02), count: 1.6, repetitions: 3, ..base() };
    let desc = desc([16, 16], 60_000, Settings { threshold: 0.3, alpha_scale: 1.0, ..settings });
    let Some(mut rig) = FlameRig::new(desc) else { return };
    let tally = check("a long list", &mut rig, &Shot::new(&given, ahead()));
    let segments = control(&mut rig).segments;
    println!("{segments} segments");
    assert!(segments > 1 && tally.hits * 20 > tally.samples, "{segments} {tally:?}");
    tally.assert_few("a long list", SHARE);
}

/// The most that a particle can have, and lists of a few particles that have very many.
#[test]
fn very_many_render_particles() {
    let small = Settings { spread: Some(0.8), size: Some(0.06), repetitions: 2, threshold: 0.5, ..base() };
    let small = Settings { alpha_scale: 1.0, ..small };
    for (count, rows, size) in [(32_768.0, 2, [16, 16]), (32_768.0, 3, [33, 33]), (2000.0, 40, [33, 17])] {
        let rows: Vec<[f32; 4]> = (0..rows).map(|i| [0.02 * i as f32, 0.0, -2.0 - 0.01 * i as f32, 2990.0]).collect();
        let settings = Settings { count, ..small.clone() };
        // Of a particle twice as hot as that there can be no more.
        let desc = Desc { hottest: 6000.0, ..desc(size, rows.len() as u32, settings) };
        let Some(mut rig) = FlameRig::new(desc) else { return };
        let name = format!("{count} of {}", rows.len());
        let tally = check(&name, &mut rig, &Shot::new(&particles(&rows), ahead()));
        let segments = control(&mut rig).segments;
        println!("{name}: {segments} segments");
        assert!(segments > 1 && tally.hits * 20 > tally.samples, "{segments} {tally:?}");
        tally.assert_few(&name, SHARE);
    }
    let given = particles(&[[0.0, 0.0, -2.0, 6000.0]]);
    let settings = Settings { count: 32_768.0, ..small };
    let Some(mut rig) = FlameRig::new(Desc { hottest: 6000.0, ..desc([16, 16], 1, settings) }) else { return };
    rig.frame(&given, ahead());
    assert_eq!(rig.prepared()[0].count, 32_768);
}

/// Many repetitions of short lists with every kind of turn: batches, queues that overflow, chunks.
#[test]
fn loops_end_by_themselves() {
    for (rows, count, repetitions) in [(1, 1.0, 30_000), (1, 20.0, 3000), (33, 1.0, 1000), (7, 5.0, 1000)] {
        let rows: Vec<[f32; 4]> = (0..rows).map(|i| [0.0, 0.0, -2.0 + 0.01 * i as f32, 2999.0]).collect();
        let (first, count) = (rows.len() - 1, count * 1.001);
        // Nothing hides anything until the last, nearest one has been looked at, which is in the first bucket.
        let settings = Settings { count, repetitions, ..opaque() };
        let Some(mut rig) = FlameRig::new(desc([16, 16], rows.len() as u32, settings)) else { return };
        rig.frame(&particles(&rows), ahead());
        let at_once = control(&mut rig).part_repetitions;
        let (sums, light) = (sums(&mut rig, repetitions), light(&rig.prepared()[first]).map(u64::from));
        let name = format!("{} rows, {repetitions} repetitions, {at_once} a dispatch", rows.len());
        assert!(sums.hits.iter().all(|hits| *hits == repetitions), "{name}: {:?}", sums.hits.iter().min());
        assert!(sums.light.iter().all(|sum| *sum == light.map(|c| c * u64::from(repetitions))), "{name}");
    }
}

/// Intensity is the fire's alone.
#[test]
fn intensity_never_touches_the_background() {
    let given = ball(60, 1);
    let backdrop: Vec<[f32; 4]> =
        (0..SIZE[0] * SIZE[1]).map(|i| [0, 1, 2, 3].map(|c| if c == 3 { 1.0 } else { random(1, i, c) })).collect();
    let frame = |intensity| {
        let mut rig = FlameRig::new(desc(SIZE, 60, Settings { intensity, ..base() }))?;
        rig.offline().set_backdrop(&backdrop).expect("a backdrop");
        rig.frame(&given, camera(0.0));
        Some((rig.mean(), rig.variance(), rig.nearest(), rig.effect(), rig.picture()))
    };
    let Some(one) = frame(1.0) else { return };
    let mut seen = 0;
    for intensity in [0.0, 1.0, 3.0, 1e6] {
        let Some((mean, variance, nearest, effect, picture)) = frame(intensity) else { return };
        assert!((&mean, &variance, &nearest) == (&one.0, &one.1, &one.2), "before exposure nothing depends on it");
        for pixel in 0..mean.len() {
            let [r, g, b, coverage] = mean[pixel];
            assert_eq!(effect[pixel], [intensity * r, intensity * g, intensity * b, coverage]);
            seen += usize::from(coverage > 0.0);
            if coverage == 0.0 {
                assert_eq!(picture[pixel], backdrop[pixel]);
            }
            for c in 0..4 {
                let over = f64::from(effect[pixel][c]) + (1.0 - f64::from(coverage)) * f64::from(backdrop[pixel][c]);
                // Blending in single precision: two roundings.
                assert!((f64::from(picture[pixel][c]) - over).abs() <= 2e-7 * over, "{intensity}: {picture:?}");
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}
