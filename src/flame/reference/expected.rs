//! The image that repetitions converge to: emission and absorption along each pixel's ray (E2 of the derivation:
//! optical depth of a particle is -n ln(1 - G)), in depth bins.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::kernel::{Body, logarithm};
use super::prepare::Particle;
use super::stochastic::Frame;
use super::weights::Weights;
use super::{drawn_back, enlarged, half_sides, world};
use crate::flame::settings::Shape;
use crate::threads::map;
use crate::view::Projection;

/// Depth bins of equal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bins {
    /// View depth where the first begins, in metres.
    pub near: f64,
    /// View depth where the last ends.
    pub far: f64,
    /// How many.
    pub count: usize,
}

impl Bins {
    /// Bins over all depths that render particles of these particles can have.
    pub fn around(frame: &Frame, particles: &[Particle], count: usize) -> Bins {
        let reach = reach(frame);
        let projection = Projection::of_valid(&frame.view, frame.size);
        let depths = particles.iter().filter(|p| p.count > 0);
        let depths = depths.map(|p| projection.to_view(world(p.centre)).z);
        let [near, far] = depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], z| [a.min(z), b.max(z)]);
        let (first, last) = (projection.near, projection.far);
        Bins { near: (near - reach).clamp(first, last), far: (far + reach).clamp(first, last), count }
    }

    /// Where bins begin and end, ascending.
    pub fn borders(&self) -> Vec<f64> {
        (0..=self.count).map(|b| self.near + (self.far - self.near) * b as f64 / self.count as f64).collect()
    }
}

/// How far a render particle can be from its particle's centre in depth.
fn reach(frame: &Frame) -> f64 {
    let spread = f64::from(frame.settings.spread.unwrap_or_default());
    match frame.settings.shape {
        Shape::Ball => spread,
        Shape::Cube => 3.0_f64.sqrt() * spread,
    }
}

/// The limit of repetitions, a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Linear RGB.
    pub mean: Vec<[f64; 3]>,
    /// Mean of the squares of one repetition's linear RGB.
    pub second: Vec<[f64; 3]>,
    /// Chance of a winner.
    pub coverage: Vec<f64>,
    /// Mean view depth of the winners in metres, each in the middle of its bin; infinite where there are none.
    pub depth: Vec<f64>,
}

impl Expected {
    /// Variance of one repetition's linear RGB.
    pub fn variance(&self) -> Vec<[f64; 3]> {
        let pixels = self.mean.iter().zip(&self.second);
        pixels.map(|(mean, second)| std::array::from_fn(|c| (second[c] - mean[c] * mean[c]).max(0.0))).collect()
    }
}

/// Renders without a table. `side`: cells of the sprite's square that are summed ([`Weights::new`]); 128 is some 1e-5
/// close where the spread is not much below the size.
pub fn render(frame: &Frame, particles: &[Particle], bins: Bins, side: usize) -> Expected {
    render_at(frame, particles, bins, side, &everywhere(frame))
}

/// The same at some pixels only, numbered row by row from the top: a whole picture takes minutes.
pub fn render_at(frame: &Frame, particles: &[Particle], bins: Bins, side: usize, pixels: &[usize]) -> Expected {
    let exact = Exact::new(frame, particles, side);
    integrate_at(frame, particles, bins, pixels, |index, slope, borders, depths| {
        exact.depths(index, slope, borders, depths)
    })
}

fn everywhere(frame: &Frame) -> Vec<usize> {
    (0..frame.size[0] as usize * frame.size[1] as usize).collect()
}

/// Composites bins front to back. `optical(particle, slope of the ray, borders, depths)` writes the optical depth that a
/// particle has between each two borders, and is false where it has none.
pub fn integrate(
    frame: &Frame,
    particles: &[Particle],
    bins: Bins,
    optical: impl Fn(usize, DVec2, &[f64], &mut [f64]) -> bool + Sync,
) -> Expected {
    integrate_at(frame, particles, bins, &everywhere(frame), optical)
}

fn integrate_at(
    frame: &Frame,
    particles: &[Particle],
    bins: Bins,
    pixels: &[usize],
    optical: impl Fn(usize, DVec2, &[f64], &mut [f64]) -> bool + Sync,
) -> Expected {
    let width = frame.size[0] as usize;
    let projection = Projection::of_valid(&frame.view, frame.size);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let pixel = |place: usize| {
        let slope = projection.slope_at(DVec2::new((place % width) as f64, (place / width) as f64) + 0.5);
        let scene = frame.scene.map_or(f64::INFINITY, |scene| f64::from(scene[place]));
        let borders: Vec<f64> = bins.borders().into_iter().map(|z| z.min(scene)).collect();
        let mut column = vec![Bin::default(); bins.count];
        let mut depths = vec![0.0; bins.count];
        for (index, particle) in particles.iter().enumerate().filter(|(_, p)| p.count > 0) {
            if optical(index, slope, &borders, &mut depths) {
                column.iter_mut().zip(&depths).for_each(|(bin, depth)| bin.add(*depth, particle.colour));
            }
        }
        composite(&column, &borders)
    };
    let pixel = &pixel;
    let each = pixels.len().div_ceil(4 * threads).max(1);
    let part = |part: &[usize]| part.iter().map(|place| pixel(*place)).collect::<Vec<Seen>>();
    let seen: Vec<Seen> = map(pixels.chunks(each), part).into_iter().flatten().collect();
    Expected {
        mean: seen.iter().map(|s| s.mean.to_array()).collect(),
        second: seen.iter().map(|s| s.second.to_array()).collect(),
        coverage: seen.iter().map(|s| s.coverage).collect(),
        depth: seen.iter().map(|s| if s.coverage > 0.0 { s.depth / s.coverage } else { f64::INFINITY }).collect(),
    }
}

/// The content of a bin: optical depth, and sums of colour and its square that it weighs.
#[derive(Clone, Copy, Default)]
struct Bin {
    optical: f64,
    colour: DVec3,
    square: DVec3,
}

impl Bin {
    fn add(&mut self, optical: f64, colour: [f64; 3]) {
        let colour = DVec3::from_array(colour);
        self.optical += optical;
        self.colour += optical * colour;
        self.square += optical * colour * colour;
    }
}

#[derive(Default)]
struct Seen {
    mean: DVec3,
    second: DVec3,
    coverage: f64,
    /// Sum of depths, each as often as it is seen.
    depth: f64,
}

// The numbers of the specification. Kernels have the nearest floats (`LEAST_NEIGHBOUR`, `ONE_COLOUR`, `OPAQUE`), and what
// they lose by that is of what the reference measures.
/// Below so many of a bin's optical depths, a neighbour's colour counts less and less.
const SURE_NEIGHBOUR: f64 = 0.01;
/// Of a bin whose colours vary by less than this share of their mean square, it is not sure that they vary.
const SAME_COLOUR: f64 = 0.01;
/// Transmittance below which nothing is seen any more.
const UNSEEN: f64 = 1e-6;

/// Lays bins behind each other. Over the optical depth x of a bin, h, colours are c + b (x - h / 2): b is the monotonised
/// central difference of the means of the bin and its neighbours (van Leer 1977, eq. 66, on a grid of unequal cells). A bin
/// whose colours vary less than b alone would make them is of a few sheets, not of a mixture that changes: b fades there.
fn composite(column: &[Bin], borders: &[f64]) -> Seen {
    let mut seen = Seen::default();
    let mut left = 1.0;
    let bin = |index: usize| column.get(index).copied().unwrap_or_default();
    for (index, ends) in borders.windows(2).enumerate() {
        let here = bin(index);
        if here.optical <= 0.0 || left <= UNSEEN {
            continue;
        }
        let (nearer, farther) = (bin(index.wrapping_sub(1)), bin(index + 1));
        let depths = [nearer.optical, here.optical, farther.optical];
        let slope = slope(depths, [nearer.colour, here.colour, farther.colour]);
        let square_slope = self::slope(depths, [nearer.square, here.square, farther.square]);
        let [colour, square] = [here.colour, here.square].map(|sum| sum / here.optical);
        let fade = fade(colour, square, slope * here.optical);
        let share = left * -(-here.optical).exp_m1();
        let lean = left * fade * leaning(here.optical);
        seen.mean += (share * colour + lean * slope).max(DVec3::ZERO);
        seen.second += (share * square + lean * square_slope).max(DVec3::ZERO);
        seen.coverage += share;
        seen.depth += share * (ends[0] + ends[1]) / 2.0;
        left *= (-here.optical).exp();
    }
    seen
}

/// The light that a slope of 1 adds to a bin: the integral of (x - h / 2) exp(-x).
fn leaning(h: f64) -> f64 {
    match h < 1e-3 {
        true => -h.powi(3) / 12.0 * (1.0 - h / 2.0),
        false => (1.0 - h / 2.0) * -(-h).exp_m1() - h * (-h).exp(),
    }
}

/// How much a slope is believed: `change` is what it makes of a bin's colours from its front to its back.
fn fade(colour: DVec3, square: DVec3, change: DVec3) -> f64 {
    let variance = (square - colour * colour).element_sum().max(0.0).powi(2);
    let own = (change.length_squared() / 24.0).powi(2);
    let least = (SAME_COLOUR * square.element_sum()).powi(2);
    variance / (variance + own + least).max(1e-30)
}

/// The slope in the middle one of three bins, from their optical depths and their colours times those.
fn slope([before, h, behind]: [f64; 3], sums: [DVec3; 3]) -> DVec3 {
    let sure = |other: f64| other / (other + SURE_NEIGHBOUR * h);
    let mean = |sum: DVec3, h: f64| if h > 0.0 { sum / h } else { DVec3::ZERO };
    let [nearer, colour, farther] = [mean(sums[0], before), mean(sums[1], h), mean(sums[2], behind)];
    DVec3::from_array(std::array::from_fn(|channel| {
        let c = colour[channel];
        let known = [(c - nearer[channel]) * 2.0 / (h + before), (farther[channel] - c) * 2.0 / (h + behind)];
        let known = [if before > 0.0 { known[0] } else { 0.0 }, if behind > 0.0 { known[1] } else { 0.0 }];
        let left = known[1] + (known[0] - known[1]) * sure(before);
        let right = known[0] + (known[1] - known[0]) * sure(behind);
        let central = (left * (h + behind) + right * (h + before)) / (2.0 * h + before + behind);
        let most = (left.abs() * (h + before)).min(right.abs() * (h + behind)).min(2.0 * c) / h;
        if left * right > 0.0 { central.clamp(-most, most) } else { 0.0 }
    }))
}

/// Particles without a table.
struct Exact<'a> {
    frame: &'a Frame<'a>,
    particles: &'a [Particle],
    projection: Projection,
    weights: Vec<Weights>,
    /// Of each particle: its centre in view space, and its weights.
    own: Vec<(DVec3, usize)>,
}

impl<'a> Exact<'a> {
    fn new(frame: &'a Frame<'a>, particles: &'a [Particle], side: usize) -> Exact<'a> {
        let mut known = BTreeMap::new();
        let mut alphas = Vec::new();
        let projection = Projection::of_valid(&frame.view, frame.size);
        let own = particles.iter().map(|p| {
            let index = *known.entry(p.alpha.to_bits()).or_insert_with(|| {
                alphas.push(p.alpha);
                alphas.len() - 1
            });
            (projection.to_view(world(p.centre)), index)
        });
        let own = own.collect();
        let threshold = f64::from(frame.settings.threshold);
        let weights =
            alphas.iter().map(|alpha| Weights::new(frame.mask, frame.level, *alpha, threshold, side)).collect();
        Exact { frame, particles, projection, weights, own }
    }

    fn body(&self, index: usize) -> Body<'_> {
        let (centre, weights) = self.own[index];
        // A sprite below one pixel is a pixel wide and passes less often. Its size at the centre is that of all: its
        // area times its chance is the same at any depth.
        let z = centre.z.max(self.projection.near);
        let half = half_sides(self.frame.settings, &self.projection, z);
        let enlarged = enlarged(half);
        Body {
            weights: &self.weights[weights],
            fill: enlarged.powi(-2),
            half: half.x * enlarged / self.projection.focal.x * self.projection.widening(z),
            spread: f64::from(self.frame.settings.spread.unwrap_or_default()),
            shape: self.frame.settings.shape,
            rotation: self.projection.axes,
        }
    }

    fn depths(&self, index: usize, slope: DVec2, borders: &[f64], depths: &mut [f64]) -> bool {
        let centre = self.own[index].0;
        let reach = reach(self.frame);
        let Projection { near, far, is_orthographic, .. } = self.projection;
        if centre.z + reach < near || centre.z - reach > far {
            return false;
        }
        let (body, beside) = (self.body(index), self.projection.widening(centre.z) * slope - centre.truncate());
        let slope = if is_orthographic { DVec2::ZERO } else { slope };
        let stretch = DVec2::from_array(self.particles[index].stretch);
        let [beside, slope] = [beside, slope].map(|way| drawn_back(way, stretch));
        if !body.touches(beside, slope) {
            return false;
        }
        let relative: Vec<f64> = borders.iter().map(|z| z - centre.z).collect();
        let range = [near, far].map(|z| z - centre.z);
        let mut shares = vec![0.0; borders.len()];
        let met = body.shares(beside, slope, range, &relative, &mut shares);
        let count = f64::from(self.particles[index].count);
        for (depth, ends) in depths.iter_mut().zip(shares.windows(2)) {
            *depth = count * (logarithm(ends[0]) - logarithm(ends[1])).max(0.0);
        }
        met
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flame::params::LIGHT_STEPS;
    use crate::flame::reference::mask::{Mask, SIDE};
    use crate::flame::reference::prepare::{self, Prepared};
    use crate::flame::reference::stochastic::{self, Rounding};
    use crate::flame::settings::{Colour, Settings};
    use crate::random::{hash, unit};
    use crate::view::Camera;

    #[derive(Clone)]
    struct Scene {
        settings: Settings,
        camera: Camera,
        size: [u32; 2],
        mask: Mask,
        level: u32,
        depth: Option<Vec<f32>>,
    }

    impl Scene {
        /// Looks along -z from the origin, 90 degrees; alpha is 1 everywhere.
        fn new(settings: Settings, size: [u32; 2]) -> Scene {
            let camera =
                Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, near: 0.1, ..Camera::default() };
            Scene { settings, camera, size, mask: Mask::from_texels(vec![1.0; SIDE * SIDE]), level: 0, depth: None }
        }

        /// One pixel that is narrower than sprites are.
        fn pixel(settings: Settings) -> Scene {
            let scene = Scene::new(settings, [1, 1]);
            Scene { camera: Camera { vertical_fov: 1.0, ..scene.camera }, ..scene }
        }

        fn frame(&self) -> Frame<'_> {
            Frame {
                settings: &self.settings,
                seed: 7,
                number: 0,
                view: self.camera.view(self.size),
                size: self.size,
                scene: self.depth.as_deref(),
                mask: &self.mask,
                level: self.level,
            }
        }

        fn prepare(&self, positions: &[[f32; 4]]) -> Prepared {
            prepare::prepare(&self.settings, 1e6, 7, &self.camera.view(self.size), positions, None)
        }

        fn render(&self, positions: &[[f32; 4]], bins: usize) -> Expected {
            let (frame, prepared) = (self.frame(), self.prepare(positions));
            render(&frame, &prepared.particles, Bins::around(&frame, &prepared.particles, bins), 128)
        }
    }

    fn red_and_blue() -> Colour {
        Colour::Ramp(vec![[1.0, 0.0, 0.0], [0.0, 0.0, 0.5]])
    }

    #[test]
    fn one_render_particle_that_always_passes_is_as_deep_as_it_is() {
        // Sprites that cover the whole ball: depths are those of points in a ball, density 3/4 (1 - z^2).
        let settings = Settings { spread: Some(0.1), size: Some(0.3), count: 1.0, ..Settings::light() };
        let scene = |count| Scene::pixel(Settings { count, ..settings.clone() });
        let single = scene(1.0).render(&[[0.0, 0.0, -2.0, 3000.0]], 400);
        assert!((single.coverage[0] - 1.0).abs() < 1e-4, "{}", single.coverage[0]);
        assert!((single.depth[0] - 2.0).abs() < 1e-4, "{}", single.depth[0]);
        assert!((single.mean[0][1] - 1.0).abs() < 1e-4 && single.variance()[0][1] < 1e-4);
        // The nearest of three: the integral of (1 - F)^3.
        let n = 100_000;
        let beyond = |i| {
            let z = -1.0 + (2.0 * f64::from(i) + 1.0) / f64::from(n);
            ((2.0 - 3.0 * z + z.powi(3)) / 4.0).powi(3) * 2.0 / f64::from(n)
        };
        let nearest = 2.0 - 0.1 + 0.1 * (0..n).map(beyond).sum::<f64>();
        let three = scene(3.0).render(&[[0.0, 0.0, -2.0, 3000.0]], 400);
        assert!((three.depth[0] - nearest).abs() < 1e-4, "{} {nearest}", three.depth[0]);
    }

    #[test]
    fn disjoint_particles_composite() {
        let settings = Settings {
            spread: Some(0.2),
            size: Some(0.2),
            count: 4.0,
            colour: red_and_blue(),
            threshold: 0.1,
            ..Settings::light()
        };
        let mut scene = Scene::pixel(settings);
        let (front, back) = ([0.05, 0.0, -2.0, 750.0], [0.0, 0.1, -3.0, 3000.0]);
        let alone = [front, back].map(|p| scene.render(&[p], 64));
        let both = scene.render(&[back, front], 64);
        let [a, b] = [0, 1].map(|i| alone[i].coverage[0]);
        assert!(a > 0.1 && b > 0.1 && a < 0.9, "{a} {b}");
        assert!((both.coverage[0] - (a + (1.0 - a) * b)).abs() < 1e-12);
        let close = |found: [f64; 3], expected: [f64; 3]| (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-12);
        assert!(close(both.mean[0], [a, 0.0, 0.5 * (1.0 - a) * b]));
        assert!(close(both.second[0], [a, 0.0, 0.25 * (1.0 - a) * b]));
        // 1 - (1 - Q)^n, from the kernel.
        let prepared = scene.prepare(&[back]);
        let exact_frame = scene.frame();
        let exact = Exact::new(&exact_frame, &prepared.particles, 128);
        let mut shares = [0.0];
        let always = [f64::NEG_INFINITY, f64::INFINITY];
        exact.body(0).shares(DVec2::new(0.0, -f64::from(0.1_f32)), DVec2::ZERO, always, &[9.0], &mut shares);
        assert!((b - (1.0 - (1.0 - shares[0]).powi(4))).abs() < 1e-12);
        // A scene between them hides the second, one within the first a part of it.
        scene.depth = Some(vec![2.5]);
        assert!((scene.render(&[back, front], 64).coverage[0] - a).abs() < 1e-12);
        scene.depth = Some(vec![2.0]);
        let half = scene.render(&[back, front], 64).coverage[0];
        assert!(half > 0.3 * a && half < 0.7 * a);
        scene.depth = Some(vec![1.0]);
        assert_eq!(scene.render(&[back, front], 64).depth, [f64::INFINITY]);
    }

    /// Particles around `middle`, within `extent` of it.
    fn cloud(n: u32, middle: [f32; 3], extent: f32) -> Vec<[f32; 4]> {
        let draw = |i, axis| unit(hash(11, i, 0, axis));
        let place = |i| -> [f32; 3] { std::array::from_fn(|a| middle[a] + extent * (2.0 * draw(i, a as u32) - 1.0)) };
        (0..n).map(|i| (place(i), 1000.0 + 2000.0 * draw(i, 3))).map(|([x, y, z], t)| [x, y, z, t]).collect()
    }

    /// Standard scores of `repetitions` against the expectation: root mean square and largest.
    fn scores(scene: &Scene, positions: &[[f32; 4]], repetitions: u32) -> [f64; 2] {
        let (frame, mut prepared) = (scene.frame(), scene.prepare(positions));
        let brightest = prepared.brightest;
        // Both see the same colours.
        for particle in &mut prepared.particles {
            particle.colour = particle.light.map(|l| f64::from(l) / f64::from(LIGHT_STEPS) * brightest);
        }
        let bins = Bins::around(&frame, &prepared.particles, 256);
        let expected = render(&frame, &prepared.particles, bins, 128);
        let sums = stochastic::render(&frame, &prepared.particles, 0..repetitions, Rounding::NONE);
        let (mean, variance, coverage) = (sums.mean(brightest), expected.variance(), sums.coverage());
        let n = f64::from(repetitions);
        let mut scores = Vec::new();
        for i in 0..mean.len() {
            let p = expected.coverage[i];
            // Rare hits are not normally distributed.
            if p * n > 50.0 && (1.0 - p) * n > 50.0 {
                scores.push((coverage[i] - p) / (p * (1.0 - p) / n).sqrt());
                let own = (0..3).filter(|c| variance[i][*c] > 1e-9);
                scores.extend(own.map(|c| (mean[i][c] - expected.mean[i][c]) / (variance[i][c] / n).sqrt()));
            } else {
                assert!((coverage[i] - p).abs() * n < 30.0, "{i}: {p} {}", coverage[i]);
            }
        }
        assert!(scores.len() > 100, "{} scores", scores.len());
        let rms = (scores.iter().map(|s| s * s).sum::<f64>() / scores.len() as f64).sqrt();
        [rms, scores.iter().fold(0.0, |largest, s| s.abs().max(largest))]
    }

    #[test]
    fn repetitions_converge_to_it() {
        let settings = Settings { spread: Some(0.3), size: Some(0.4), count: 4.0, ..Settings::light() };
        let camera = Camera {
            eye: DVec3::new(0.3, 0.2, 1.0),
            target: DVec3::new(0.0, 0.1, -1.0),
            vertical_fov: 80.0,
            near: 0.1,
            ..Camera::default()
        };
        // To the side, where the ray is slanted, and so near that perspective is strong within a particle.
        let positions = cloud(12, [1.1, 0.5, -0.9], 0.4);
        let ball = Scene { camera, mask: Mask::new(7, 4), ..Scene::new(settings.clone(), [24, 18]) };
        let cube = Scene { settings: Settings { shape: Shape::Cube, ..settings.clone() }, ..ball.clone() };
        let minified = Scene { level: 3, ..ball.clone() };
        let depth = (0..24 * 18).map(|i| if i % 24 < 18 { f32::INFINITY } else { 2.1 }).collect();
        let cut = Camera { near: 1.9, far: 2.4, ..camera };
        let occluded = Scene { depth: Some(depth), camera: cut, ..ball.clone() };
        for (name, scene) in [("ball", &ball), ("cube", &cube), ("minified", &minified), ("occluded", &occluded)] {
            let [rms, largest] = scores(scene, &positions, 4096);
            assert!((0.7..1.3).contains(&rms) && largest < 4.5, "{name}: {rms} {largest}");
        }
    }

    #[test]
    fn sprites_below_a_pixel_converge_too() {
        let settings = Settings { spread: Some(0.5), size: Some(0.05), count: 40.0, ..Settings::light() };
        let scene = Scene { mask: Mask::new(7, 4), level: 6, ..Scene::new(settings, [16, 12]) };
        let [rms, largest] = scores(&scene, &cloud(10, [0.0, 0.0, -2.0], 0.5), 8192);
        assert!((0.7..1.3).contains(&rms) && largest < 4.5, "{rms} {largest}");
    }

    fn difference(a: &Expected, b: &Expected) -> f64 {
        let channels = a.mean.iter().zip(&b.mean).flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).powi(2)));
        (channels.sum::<f64>() / (3 * a.mean.len()) as f64).sqrt()
    }

    #[test]
    fn bins_and_cells_converge() {
        let settings = Settings { spread: Some(0.25), size: Some(0.25), count: 10.0, ..Settings::light() };
        let scene = Scene { mask: Mask::new(7, 4), ..Scene::new(settings, [20, 15]) };
        let (frame, prepared) = (scene.frame(), scene.prepare(&cloud(30, [0.0, 0.0, -2.0], 0.7)));
        let run =
            |count, side| render(&frame, &prepared.particles, Bins::around(&frame, &prepared.particles, count), side);
        let truth = run(1024, 256);
        let errors = [16, 32, 64].map(|count| difference(&run(count, 256), &truth));
        assert!(errors[1] < 5e-4 && errors[1] < errors[0] / 2.5 && errors[2] < errors[1] / 2.5, "{errors:?}");
        let cells = [64, 128].map(|side| difference(&run(1024, side), &truth));
        assert!(cells[0] < 1e-4 && cells[1] < 2e-5, "{cells:?}");
    }

    #[test]
    fn a_slanted_ray_in_steps_along_the_axis_needs_its_own_sum() {
        // What a table can say: in each bin, the ray where it is in the middle of the bin, as if along the view axis.
        // Differences of its G are right to second order; its G itself is that of another ray, and a floor is left.
        let settings = Settings { spread: Some(0.25), size: Some(0.25), count: 4.0, ..Settings::light() };
        let scene = Scene { mask: Mask::new(7, 4), ..Scene::new(settings, [12, 9]) };
        let (frame, prepared) = (scene.frame(), scene.prepare(&cloud(30, [0.0, 0.0, -1.5], 0.7)));
        let particles = &prepared.particles;
        let exact = Exact::new(&frame, particles, 128);
        let [coarse, fine] = [32, 64].map(|count| {
            let bins = Bins::around(&frame, particles, count);
            let always = [f64::NEG_INFINITY, f64::INFINITY];
            let run = |summed: bool| {
                integrate(&frame, particles, bins, |index, slope, borders, depths| {
                    let centre = exact.own[index].0;
                    let count = f64::from(particles[index].count);
                    let mut share = 0.0;
                    for (depth, ends) in depths.iter_mut().zip(borders.windows(2)) {
                        let beside = (ends[0] + ends[1]) / 2.0 * slope - centre.truncate();
                        let relative = [ends[0] - centre.z, ends[1] - centre.z];
                        let mut shares = [0.0; 2];
                        exact.body(index).shares(beside, DVec2::ZERO, always, &relative, &mut shares);
                        if summed {
                            let before = share;
                            share += shares[1] - shares[0];
                            shares = [before, share];
                        }
                        *depth = count * (logarithm(shares[0]) - logarithm(shares[1])).max(0.0);
                    }
                    true
                })
            };
            let truth = render(&frame, particles, bins, 128);
            [difference(&run(false), &truth), difference(&run(true), &truth)]
        });
        assert!(coarse[0] < 2e-3 && coarse[1] < 5e-4, "{coarse:?}");
        assert!(fine[0] > 0.7 * coarse[0] && fine[1] < 0.4 * coarse[1], "{fine:?} {coarse:?}");
    }
}
