//! The Gaussian under the mask of groups against the reference, on images that are hard for separable forms.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::low_level::smoke::params::{GROUP_BITS, GROUP_MASK, LUMINANCE_ONE};
use celfx::smoke::Settings;
use celfx::smoke::reference::gaussian::masked_separable;
use celfx::smoke::settings::Mask;
use celfx::view::{Camera, Light};

use crate::common::bench::{Bench, Given};
use crate::common::scenes::{desc, random, volume};
use crate::common::unpacked;

/// Steps whose results the tests write: what pixels see, and their luminance.
pub const WRITTEN: &[&str] = &["smoke.clear", "smoke.shadow", "smoke.spheres", "smoke.luminance"];

pub fn nothing() -> Volume {
    volume([1; 3], [1.0; 3], [0.0; 3], |_, _, _| 0.0)
}

fn bench(size: [u32; 2], sigma: f32, cutoff: f32, groups: u32) -> Option<Bench> {
    let mask = Mask::Groups;
    let settings = Settings { particles: 1, fade: 0, mask, sigma, cutoff, groups, ..Settings::default() };
    let mut bench = Bench::new(desc(size, [1; 3], settings))?;
    // Images leave layout UNDEFINED in the first frame.
    run(&mut bench, &[]);
    Some(bench)
}

fn run(bench: &mut Bench, omit: &[&str]) {
    let (camera, light) = (Camera::default(), Light::default());
    bench.run(&Given { camera, light, volume: &nothing(), frames: 0, rendered: true, omit });
}

/// Filters an image of packed pixels; returns the greatest difference from the reference.
fn error(bench: &mut Bench, name: &str, pixels: &[u32]) -> f64 {
    let [width, height] = bench.desc.size.map(|n| n as usize);
    // Group alone; any slot will do, as luminance is written.
    bench.write_seen(
        &pixels
            .iter()
            .map(|p| if p & GROUP_MASK == 0 { 0 } else { 1 << GROUP_BITS | p & GROUP_MASK })
            .collect::<Vec<_>>(),
    );
    bench.write(layout::PIXELS, pixels);
    bench.write(
        layout::DEPTH,
        &pixels.iter().map(|p| if p & GROUP_MASK == 0 { f32::INFINITY } else { 3.0 }).collect::<Vec<_>>(),
    );
    bench.write(layout::SMOOTH, &vec![0.0_f32; pixels.len()]);
    run(bench, WRITTEN);
    let actual: Vec<f32> = bench.read(layout::SMOOTH, pixels.len());
    let (luminance, id) = unpacked(pixels);
    let settings = &bench.desc.settings;
    let expected = masked_separable(width, height, &luminance, &id, settings.sigma, settings.cutoff);
    let mut worst = 0.0_f64;
    for (pixel, (actual, expected)) in actual.iter().zip(&expected).enumerate() {
        assert!(actual.is_finite(), "{name}: pixel {pixel} is {actual}");
        worst = worst.max((f64::from(*actual) - expected).abs());
    }
    worst
}

/// Packs luminance 0 to 1 and group of each pixel.
fn image([width, height]: [u32; 2], pixel: impl Fn(u32, u32) -> (f32, u32)) -> Vec<u32> {
    let pack =
        |(luminance, id): (f32, u32)| if id == 0 { 0 } else { ((luminance * LUMINANCE_ONE) as u32) << GROUP_BITS | id };
    (0..width * height).map(|i| pack(pixel(i % width, i / width))).collect()
}

fn hard_images(size: [u32; 2], groups: u32) -> Vec<(&'static str, Vec<u32>)> {
    let noise = |x: u32, y: u32| random(11, y * 1000 + x, 0);
    let slanted = |x: u32, y: u32| if 7 * x > 10 * y { 1 } else { 2 };
    vec![
        ("one group", image(size, |x, y| (noise(x, y), 1))),
        ("constant", image(size, |_, _| (1.0, 2))),
        ("checkerboard", image(size, |x, y| (noise(x, y), 1 + (x + y) % 2))),
        ("black and white", image(size, |x, y| (((x + y) % 2) as f32, 1 + (x + y) % 2))),
        ("vertical strips", image(size, |x, y| (noise(x, y), 1 + x % groups))),
        ("horizontal strips", image(size, |x, y| (noise(x, y), 1 + y % groups))),
        (
            "diagonal strips between nothing",
            image(size, |x, y| (noise(x, y), if (x + 2 * y) % 5 == 0 { 3 } else { 0 })),
        ),
        ("another group every pixel", image(size, |x, y| (noise(x, y), 1 + (x + y * 37) % groups))),
        ("random groups", image(size, |x, y| (noise(x, y), (random(12, y * 1000 + x, 1) * 5.0) as u32))),
        ("slanted, dark and bright", image(size, |x, y| ((slanted(x, y) == 2) as u32 as f32, slanted(x, y)))),
        ("slanted ramp", image(size, |x, y| ((x + 2 * y) as f32 / 600.0, slanted(x, y)))),
        ("one pixel", image(size, |x, y| (0.7, u32::from([x, y] == [size[0] / 2, size[1] / 3])))),
        ("far apart", image(size, |x, y| (noise(x, y), u32::from(x % 61 == 0 && y % 47 == 3) * 5))),
        ("nothing", image(size, |_, _| (0.0, 0))),
    ]
}

fn all_images(size: [u32; 2], sigma: f32, cutoff: f32, bound: f64) {
    let groups = 8;
    let Some(mut bench) = bench(size, sigma, cutoff, groups) else { return };
    let mut worst = 0.0_f64;
    for (name, pixels) in hard_images(size, groups) {
        let error = error(&mut bench, name, &pixels);
        // The bound of the specification; sums of f32 are added small weights first.
        assert!(error <= bound, "{name}, sigma {sigma}: {error:e}");
        worst = worst.max(error);
    }
    println!("sigma {sigma}, cutoff {cutoff}: at most {worst:.2e}");
}

#[test]
fn equals_the_reference_up_to_sigma_12() {
    for (sigma, cutoff) in [(0.1, 3.0), (0.5, 3.0), (4.0, 3.0), (8.0, 3.0), (12.0, 4.0)] {
        all_images([131, 77], sigma, cutoff, 2e-6);
    }
}

#[test]
fn equals_the_reference_up_to_sigma_64() {
    all_images([150, 101], 64.0, 4.0, 4e-6);
    all_images([150, 101], 31.0, 3.0, 4e-6);
}

#[test]
fn pictures_of_one_pixel_and_one_row() {
    for size in [[1, 1], [511, 3], [3, 300]] {
        all_images(size, 4.0, 3.0, 2e-6);
    }
}

#[test]
fn all_groups_in_several_batches() {
    let size = [260, 190];
    let Some(mut bench) = bench(size, 4.0, 3.0, 254) else { return };
    assert!(bench.layout.batches > 1, "one batch holds all groups: the test shows nothing");
    for (name, pixels) in hard_images(size, 254).into_iter().skip(4) {
        let error = error(&mut bench, name, &pixels);
        // As above.
        assert!(error <= 2e-6, "{name}: {error:e}");
    }
}
