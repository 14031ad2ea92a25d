//! Tones and lines, given what they are made from: the smoothed luminance is read back, depth is the test's own.

use celfx::low_level::smoke::layout;
use celfx::low_level::smoke::params::{GROUP_BITS, GROUP_MASK, LUMINANCE_ONE};
use celfx::smoke::Settings;
use celfx::smoke::reference::outline::{self, Mark};
use celfx::smoke::reference::tone::{self, Canvas};
use celfx::smoke::settings::{LINES, Line, Mask, Operator, Outline};
use celfx::toon::Tone;
use celfx::view::{Camera, Light};

use crate::common::apart;
use crate::common::bench::{Bench, Given};
use crate::common::scenes::{camera, desc, random, volume};
use crate::common::unpacked;

const SIZE: [u32; 2] = [97, 70];
const COUNT: usize = 97 * 70;
/// Sides of the volume's voxels in metres; the smallest is the unit of lines.
const VOXEL: [f32; 3] = [0.1, 0.08, 0.2];

/// A hard image: three groups with slanted borders, holes, slopes, steps, and noise in a corner.
fn image() -> (Vec<u32>, Vec<f32>) {
    let pixel = |i: usize| {
        let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]];
        let noise = |d| random(21, i as u32, d);
        let hole = (x as i32 - 50).pow(2) + (y as i32 - 30).pow(2) < 60 || x < 3 && y > 40;
        let id = if hole { 0 } else { 1 + u32::from(3 * x > 2 * y + 30) + u32::from(x + 4 * y > 250) };
        let corner = x > 80 && y < 20;
        let luminance = if corner { noise(0) } else { 0.5 + 0.4 * (x as f32 * 0.06).sin() * (y as f32 * 0.09).cos() };
        let step = [0.0, 0.03, 0.5][id.saturating_sub(1) as usize];
        let depth = 4.0 + step + 0.001 * x as f32 + if corner { 0.1 * noise(1) } else { 0.02 * (y as f32 * 0.2).sin() };
        let depth = if id == 0 { f32::INFINITY } else { depth };
        (((luminance * LUMINANCE_ONE) as u32) << GROUP_BITS | id, depth)
    };
    let (pixels, depth): (Vec<u32>, Vec<f32>) = (0..COUNT).map(pixel).unzip();
    (pixels.into_iter().map(|p| if p & GROUP_MASK == 0 { 0 } else { p }).collect(), depth)
}

/// Runs the steps from tiles to the composite on the image, and compares with the reference.
fn assert_drawn(name: &str, settings: Settings) {
    let settings = Settings { particles: 1, fade: 0, groups: 3, ..settings }.in_pixels(LINES);
    let Some(mut bench) = Bench::new(desc(SIZE, [2; 3], settings.clone())) else { return };
    let (pixels, depth) = image();
    let camera = Camera { near: 0.01, ..camera(0.0) };
    let empty = volume([2; 3], VOXEL, [0.0; 3], |_, _, _| 0.0);
    let mut given = Given { camera, light: Light::default(), volume: &empty, frames: 0, rendered: true, omit: &[] };
    // Images leave layout UNDEFINED, and layers are cleared, in the first frame.
    bench.run(&given);
    bench.write_seen(
        &pixels.iter().map(|p| if *p == 0 { 0 } else { 1 << GROUP_BITS | p & GROUP_MASK }).collect::<Vec<_>>(),
    );
    bench.write(layout::PIXELS, &pixels);
    bench.write(layout::DEPTH, &depth);
    given.omit = &["smoke.clear", "smoke.shadow", "smoke.spheres", "smoke.luminance"];
    bench.run(&given);

    let (luminance, id) = unpacked(&pixels);
    let smooth = match settings.sigma > 0.0 {
        true => bench.read::<f32>(layout::SMOOTH, COUNT).into_iter().map(f64::from).collect(),
        false => luminance,
    };
    let depth: Vec<f64> = depth.into_iter().map(f64::from).collect();
    let tones = tone::tones(SIZE, &smooth, &id, settings.mask, &settings.tones, settings.tone_softness.into());
    let voxel = f64::from(VOXEL.into_iter().fold(f32::MAX, f32::min));
    let marks = outline::marks(SIZE, &depth, &camera.view(SIZE), voxel, &settings.outline);
    let is_hard = settings.outline.operator == Operator::Step;
    assert!(!is_hard || !marks.iter().any(is_unsure), "{name}: what is compared is not decided by rounding");
    let lines = outline::outline(SIZE, &depth, &camera.view(SIZE), voxel, &settings.outline);
    let picture = tone::composite(&tones, &lines, &id, &settings.outline);
    let both = lines;
    let lines: Vec<f64> = both.iter().map(|[inner, silhouette]| inner.max(*silhouette)).collect();
    let drawn: Vec<[f32; 4]> = bench.read(layout::PICTURE, COUNT);
    let tone_layer: Vec<[f32; 4]> = bench.read(layout::TONE_LAYER, COUNT);
    let line_layer: Vec<[f32; 4]> = bench.read(layout::OVERLAY_LAYER, COUNT);
    let mattes: Vec<[f32; 4]> = bench.read(layout::MATTE_LAYER, COUNT);
    let canvas = Canvas { size: SIZE, id: &id, mask: settings.mask, softness: settings.tone_softness.into() };
    let expected_mattes = canvas.mattes(&smooth, &settings.tones);
    let mut worst = [0.0_f64; 3];
    for pixel in 0..COUNT {
        let [inner, silhouette] = both[pixel];
        worst[0] = worst[0].max(apart(line_layer[pixel][0], inner.max(silhouette)));
        worst[0] = worst[0].max(apart(line_layer[pixel][1], silhouette));
        for c in 0..4 {
            worst[1] = worst[1].max(apart(mattes[pixel][c], expected_mattes[pixel][c]));
        }
        let whole: f32 = mattes[pixel].iter().sum();
        assert!((whole - if id[pixel] == 0 { 0.0 } else { 1.0 }).abs() < 1e-6, "{name}: {whole} of a pixel");
        for c in 0..3 {
            worst[1] = worst[1].max(apart(tone_layer[pixel][c], tones[pixel][c]));
        }
        for c in 0..4 {
            worst[2] = worst[2].max(apart(drawn[pixel][c], picture[pixel][c]));
        }
    }
    println!("{name}: lines {:.1e}, tones {:.1e}, picture {:.1e}", worst[0], worst[1], worst[2]);
    // The same values go in, so only a dozen roundings of f32 remain. In a line's l' differences of depth are squared in
    // units of a voxel, but what is not clipped is below 1; a tone's share divides by a slope, and is clipped, too.
    assert!(worst.iter().all(|worst| *worst <= 1e-5), "{name}: {worst:?}");
    let inked = lines.iter().filter(|o| **o > 0.4).count();
    assert_eq!(inked > 100, settings.outline.is_on(), "{name}: {inked} pixels of ink");
}

/// Whether a step is so near to a limit of ink that f32 may decide otherwise: depths near 4 are rounded to 5e-7, their second
/// differences are in units of at least 0.08, and a strength of 5 multiplies them.
fn is_unsure(mark: &Mark) -> bool {
    let near = |height: f64| [0.4, 1.0].iter().any(|limit: &f64| (height - limit).abs() < 1e-4);
    matches!(mark, Mark::Inner(height) if near(*height))
}

fn tones(count: usize) -> Vec<Tone> {
    (0..count).map(|i| Tone::new(i as f32 / count as f32, [i as f32 * 0.2, 1.0 - i as f32 * 0.1, 0.5])).collect()
}

#[test]
fn tones_are_those_of_the_reference() {
    for count in [1, 2, 3, 5] {
        for tone_softness in [0.0, 0.5, 4.0] {
            let name = format!("{count} tones, softness {tone_softness}");
            assert_drawn(&name, Settings { tones: tones(count), tone_softness, ..Settings::default() });
        }
    }
    for sigma in [0.0, 4.0] {
        let soft = Settings { mask: Mask::Soft, sigma, tone_softness: 4.0, ..Settings::default() };
        assert_drawn("the soft mask", soft);
    }
    // Without a Gaussian the luminance itself is cut.
    assert_drawn("no Gaussian", Settings { sigma: 0.0, ..Settings::default() });
    let late = vec![Tone::new(0.3, [1.0; 3]), Tone::new(1.0, [0.0; 3])];
    assert_drawn("the first from reads as 0", Settings { tones: late, tone_softness: 0.0, ..Settings::default() });
}

#[test]
fn lines_are_those_of_the_reference() {
    for operator in [Operator::Roberts, Operator::Second] {
        for (width, strength) in [(1.0, 1.0), (1.5, 0.1), (1.5, 1.0), (3.0, 20.0), (16.0, 1.0)] {
            let outline = Outline { strength, width, colour: [0.1, 0.0, 0.6], operator, ..Outline::default() };
            let name = format!("{operator:?}, width {width}, strength {strength}");
            assert_drawn(&name, Settings { outline, sigma: 0.0, ..Settings::default() });
        }
    }
    let none = Outline { strength: 0.0, ..Outline::default() };
    assert_drawn("no line", Settings { outline: none, ..Settings::default() });
}

/// Steps of all heights beside noise: ink that is traced over the borders of tiles, pieces that go and pieces that stay.
#[test]
fn steps_are_those_of_the_reference() {
    for (strength, width, taper, follow, shortest) in [
        (1.0, 1.5, 0.5, 16.0, 8.0),
        (1.0, 1.0, 0.0, 5.0, 0.0),
        (0.2, 3.0, 1.0, 0.0, 3.0),
        (5.0, 2.25, 0.5, 1.0, 13.0),
        (0.7, 16.0, 0.25, 16.0, 4.5),
    ] {
        let outline =
            Outline { strength, width, taper, follow, shortest, colour: [0.1, 0.0, 0.6], ..Outline::default() };
        let name =
            format!("step, strength {strength}, width {width}, taper {taper}, follow {follow}, shortest {shortest}");
        assert_drawn(&name, Settings { outline, sigma: 0.0, ..Settings::default() });
    }
}

#[test]
fn silhouettes_and_inner_lines_may_differ() {
    let line = |strength, width, colour| Line { strength: Some(strength), width: Some(width), colour: Some(colour) };
    for operator in [Operator::Step, Operator::Roberts, Operator::Second] {
        for (silhouette, inner) in [
            (line(1.0, 4.0, [0.0, 0.0, 1.0]), line(2.0, 1.5, [1.0, 0.0, 0.0])),
            (line(0.5, 1.0, [0.0, 0.2, 0.0]), Line::default()),
            (line(0.0, 1.0, [0.0; 3]), line(4.0, 2.0, [0.1; 3])),
            (Line::default(), line(0.0, 1.0, [0.0; 3])),
        ] {
            let outline = Outline { operator, silhouette, inner, ..Outline::default() };
            let name = format!("{operator:?}, {silhouette:?}, {inner:?}");
            assert_drawn(&name, Settings { outline, ..Settings::default() });
        }
    }
}
