//! The Gaussian under the soft mask against the reference, given the same coordinates of depth.

use celfx::low_level::smoke::layout;
use celfx::low_level::smoke::params::{Control, GROUP_BITS, History, LUMINANCE_ONE, Range};
use celfx::smoke::Settings;
use celfx::smoke::reference::gaussian::soft_separable;
use celfx::smoke::settings::Mask;
use celfx::view::{Camera, Light};

use crate::common::bench::{Bench, Given};
use crate::common::scenes::{desc, random};
use crate::common::unpacked;
use crate::gaussian::{WRITTEN, nothing};

/// Where the first range of depth begins, and how wide each is, in metres: rounded, and exact in binary.
const RANGES: [[f32; 2]; 2] = [[2.7, 0.21], [3.0, 0.25]];

/// Luminance, and where a pixel lies in ranges; none where it is empty.
type Pixel = Option<(f32, f32)>;

/// A bench, and what its kernels take depths by.
struct Soft {
    bench: Bench,
    range: [f32; 2],
    control: Control,
}

impl Soft {
    fn new(size: [u32; 2], sigma: f32, cutoff: f32, groups: u32, range: [f32; 2]) -> Option<Soft> {
        let mask = Mask::Soft;
        let settings = Settings { particles: 1, fade: 0, mask, sigma, cutoff, groups, ..Settings::default() };
        let mut bench = Bench::new(desc(size, [1; 3], settings))?;
        // Images leave layout UNDEFINED in the first frame.
        run(&mut bench, 0, &[]);
        let mut soft = Soft { bench, range, control: Control::reset() };
        soft.run();
        soft.control = soft.bench.read(layout::CONTROL, 1)[0];
        Some(soft)
    }

    /// A second frame: nothing lives, so that the range of the one before stays.
    fn run(&mut self) {
        let [low, width] = self.range;
        let before = Range { low, high: low + width * self.groups() as f32, exists: 1, lowest: low, highest: low };
        self.bench.write(layout::HISTORY, &[History { ranges: [before; 2] }]);
        run(&mut self.bench, 1, WRITTEN);
    }

    fn groups(&self) -> u32 {
        self.bench.desc.settings.groups
    }

    /// The same computation as the kernels': difference and product in f32, which round alike everywhere.
    fn coordinate(&self, depth: f32) -> f32 {
        let Control { group_start, groups_per_metre, .. } = self.control;
        ((depth - group_start) * groups_per_metre).clamp(0.0, self.groups() as f32)
    }

    /// What the kernels make of an image, what they were given, and the coordinates of its pixels.
    fn filtered(&mut self, image: &[Pixel]) -> (Vec<f32>, Vec<u32>, Vec<f64>) {
        let depth = |pixel: &Pixel| pixel.map_or(f32::INFINITY, |(_, u)| self.range[0] + u * self.range[1]);
        let depths: Vec<f32> = image.iter().map(depth).collect();
        let group = |depth: &f32| match depth.is_finite() {
            true => (self.coordinate(*depth) as u32).min(self.groups() - 1) + 1,
            false => 0,
        };
        let ids: Vec<u32> = depths.iter().map(group).collect();
        let word = |(pixel, id): (&Pixel, &u32)| {
            pixel.map_or(0, |(luminance, _)| ((luminance * LUMINANCE_ONE) as u32) << GROUP_BITS | id)
        };
        let pixels: Vec<u32> = image.iter().zip(&ids).map(word).collect();
        let at = |depth: &f32| if depth.is_finite() { self.coordinate(*depth).into() } else { f64::INFINITY };
        let coordinates = depths.iter().map(at).collect();
        // Group alone; any slot will do, as luminance is written.
        let seen = |id: &u32| if *id == 0 { 0 } else { 1 << GROUP_BITS | id };
        self.bench.write_seen(&ids.iter().map(seen).collect::<Vec<_>>());
        self.bench.write(layout::PIXELS, &pixels);
        self.bench.write(layout::DEPTH, &depths);
        self.bench.write(layout::SMOOTH, &vec![0.0_f32; pixels.len()]);
        self.run();
        (self.bench.read(layout::SMOOTH, pixels.len()), pixels, coordinates)
    }

    /// The greatest difference from the reference.
    fn error(&mut self, name: &str, image: &[Pixel]) -> f64 {
        let (actual, pixels, coordinates) = self.filtered(image);
        let [width, height] = self.bench.desc.size.map(|n| n as usize);
        let Settings { sigma, cutoff, .. } = self.bench.desc.settings;
        let expected = soft_separable(width, height, &unpacked(&pixels).0, &coordinates, sigma, cutoff);
        let mut worst = 0.0_f64;
        for (pixel, (actual, expected)) in actual.iter().zip(&expected).enumerate() {
            assert!(actual.is_finite(), "{name}: pixel {pixel} is {actual}");
            worst = worst.max((f64::from(*actual) - expected).abs());
        }
        worst
    }
}

fn run(bench: &mut Bench, frames: u32, omit: &[&str]) {
    let (camera, light) = (Camera::default(), Light::default());
    bench.run(&Given { camera, light, volume: &nothing(), frames, rendered: true, omit });
}

fn image([width, height]: [u32; 2], pixel: impl Fn(u32, u32) -> Pixel) -> Vec<Pixel> {
    (0..width * height).map(|i| pixel(i % width, i / width)).collect()
}

fn noise(x: u32, y: u32, dimension: u32) -> f32 {
    random(11, y * 1000 + x, dimension)
}

fn hard_images(size: [u32; 2], groups: u32) -> Vec<(&'static str, Vec<Pixel>)> {
    let most = groups as f32;
    let all = |u: &dyn Fn(u32, u32) -> f32| image(size, |x, y| Some((noise(x, y, 0), u(x, y))));
    vec![
        ("one depth", all(&|_, _| 0.37 * most)),
        ("between two planes", all(&|_, _| 0.5)),
        ("white", image(size, |x, y| Some((1.0, noise(x, y, 1) * most)))),
        ("whole numbers", all(&|x, y| ((x + 3 * y) % (groups + 1)) as f32)),
        ("both ends", all(&|x, y| ((x + y) % 2) as f32 * most)),
        ("beyond both ends", all(&|x, y| (2.0 * noise(x, y, 1) - 0.5) * most)),
        ("another depth every pixel", all(&|x, y| noise(x, y, 1) * most)),
        ("black and white", image(size, |x, y| Some((((x + y) % 2) as f32, ((x + y) % 2) as f32 * 0.9)))),
        ("slanted", all(&|x, y| (x + 2 * y) as f32 * most / 300.0)),
        ("nearly flat", all(&|x, y| (0.999 + 1e-5 * (x + y) as f32).min(most))),
        ("vertical strips", all(&|x, _| (x % (groups + 1)) as f32 * 0.9)),
        ("horizontal strips", all(&|_, y| (y % (groups + 1)) as f32 * 0.9)),
        (
            "diagonal strips between nothing",
            image(size, |x, y| ((x + 2 * y) % 5 == 0).then(|| (noise(x, y, 0), noise(x, y, 1) * most))),
        ),
        ("holes", image(size, |x, y| (noise(x, y, 2) > 0.4).then(|| (noise(x, y, 0), (x + y) as f32 * most / 200.0)))),
        ("one pixel", image(size, |x, y| ([x, y] == [size[0] / 2, size[1] / 3]).then_some((0.7, 0.6)))),
        ("far apart", image(size, |x, y| (x % 61 == 0 && y % 47 == 3).then(|| (noise(x, y, 0), 0.3 * most)))),
        ("nothing", image(size, |_, _| None)),
    ]
}

fn all_images(size: [u32; 2], sigma: f32, cutoff: f32, groups: u32, bound: f64) {
    for range in RANGES {
        let Some(mut soft) = Soft::new(size, sigma, cutoff, groups, range) else { return };
        let mut worst = 0.0_f64;
        for (name, pixels) in hard_images(size, groups) {
            let error = soft.error(name, &pixels);
            // The bound of the specification; sums of f32 are added small weights first.
            assert!(error <= bound, "{name}, sigma {sigma}, {groups} groups: {error:e}");
            worst = worst.max(error);
        }
        println!("sigma {sigma}, cutoff {cutoff}, {groups} groups: at most {worst:.2e}");
    }
}

#[test]
fn equals_the_reference_up_to_sigma_12() {
    for (sigma, cutoff) in [(0.1, 3.0), (0.5, 3.0), (4.0, 3.0), (8.0, 3.0), (12.0, 4.0)] {
        all_images([131, 77], sigma, cutoff, 8, 2e-6);
    }
}

#[test]
fn equals_the_reference_up_to_sigma_64() {
    all_images([150, 101], 64.0, 4.0, 8, 4e-6);
    all_images([150, 101], 31.0, 3.0, 8, 4e-6);
}

#[test]
fn pictures_of_one_pixel_and_one_row() {
    for size in [[1, 1], [511, 3], [3, 300]] {
        all_images(size, 4.0, 3.0, 8, 2e-6);
    }
}

#[test]
fn any_number_of_groups() {
    for groups in [1, 2, 31, 32, 33, 254] {
        all_images([70, 45], 4.0, 3.0, groups, 2e-6);
    }
}

#[test]
fn all_planes_in_several_batches() {
    let size = [260, 190];
    let Some(mut soft) = Soft::new(size, 4.0, 3.0, 254, RANGES[0]) else { return };
    let layout = &soft.bench.layout;
    assert!(layout.batches > 1, "one batch holds all planes: the test shows nothing");
    assert_eq!(layout.row_groups, layout.batch_groups + 1, "the last plane stays");
    for (name, pixels) in hard_images(size, 254) {
        let error = soft.error(name, &pixels);
        // As above.
        assert!(error <= 2e-6, "{name}: {error:e}");
    }
}

/// Pixels of other planes make the kernels look at more blocks and list more tiles, and change no bit.
#[test]
fn what_is_left_out_changes_no_bit() {
    let size = [190, 130];
    let Some(mut soft) = Soft::new(size, 5.0, 3.0, 80, RANGES[0]) else { return };
    let some = |x: u32, y: u32| x % 50 < 9 && y % 37 < 11;
    let near = |x: u32, y: u32| some(x, y).then(|| (noise(x, y, 0), 3.0 + 2.0 * noise(x, y, 1)));
    let alone = soft.filtered(&image(size, near)).0;
    // Of the first, some planes' bits are the same as those of the pixels above.
    for from in [35.0, 8.0] {
        let beside = |x: u32, y: u32| near(x, y).or(Some((noise(x, y, 0), from + 30.0 * noise(x, y, 1))));
        let among = soft.filtered(&image(size, beside)).0;
        for (pixel, (alone, among)) in alone.iter().zip(&among).enumerate() {
            if some(pixel as u32 % size[0], pixel as u32 / size[0]) {
                assert_eq!(alone.to_bits(), among.to_bits(), "pixel {pixel}");
            }
        }
    }
}

/// A slanted plane through all ranges under smooth light: no step where one range ends.
#[test]
fn a_slanted_plane_has_no_seam() {
    let size = [256, 160];
    let light = |x: u32, y: u32| 0.5 + 0.3 * (0.04 * x as f32 + 0.02 * y as f32).sin();
    let slanted = image(size, |x, y| Some((light(x, y), (3 * x + y) as f32 * 8.0 / 930.0)));
    // The greatest difference of neighbours before the Gaussian: an average of shifted ones has no greater.
    let slope = 0.3 * 0.04_f64;
    let Some(mut soft) = Soft::new(size, 6.0, 3.0, 8, RANGES[0]) else { return };
    let (smooth, pixels, coordinates) = soft.filtered(&slanted);
    let step = steps(size, &smooth);
    // The same pixels under the mask of groups, to show what a seam is.
    let id: Vec<u32> = coordinates.iter().map(|u| (*u as u32).min(7) + 1).collect();
    let [width, height] = size.map(|n| n as usize);
    let (luminance, reference) = (unpacked(&pixels).0, celfx::smoke::reference::gaussian::masked_separable);
    let grouped = steps(size, &reference(width, height, &luminance, &id, 6.0, 3.0));
    println!("steps of {:.2} slopes, with groups {:.2}", step / slope, grouped / slope);
    // Shares change beside the Gaussian's weights, so that averages shift by a little more than a pixel a pixel.
    assert!(step < 1.2 * slope, "{step} where the light changes by {slope} a pixel");
    assert!(grouped > 4.0 * slope, "{grouped}: the test shows nothing");
}

/// The greatest difference between neighbours in a row.
fn steps<T: Copy + Into<f64>>([width, _]: [u32; 2], image: &[T]) -> f64 {
    let rows = image.chunks(width as usize);
    rows.flat_map(|row| row.windows(2).map(|two| (two[1].into() - two[0].into()).abs())).fold(0.0, f64::max)
}
