//! A frame's repetitions on the device and in the reference: integer sums, bit for bit.

use celfx::data::Particles;
use celfx::flame::FlameKind;
use celfx::flame::reference::mask::Mask;
use celfx::flame::reference::prepare::{self, Particle, Prepared};
use celfx::flame::reference::stochastic::{Frame, Rounding, render};
use celfx::flame::reference::sums::Sums;
use celfx::low_level::flame::layout;
use celfx::low_level::flame::params::{self, Control, TILE};
use celfx::offline::{EffectBuffer, Scene};
use celfx::view::{Camera, View};

use crate::common::flame::FlameRig;

/// What is seen.
#[derive(Clone, Copy)]
pub struct Shot<'a> {
    pub particles: &'a Particles,
    pub camera: Camera,
    /// What it is seen through instead, if it is not a camera's.
    pub view: Option<View>,
    pub number: u32,
    pub depth: Option<&'a [f32]>,
}

impl<'a> Shot<'a> {
    pub fn new(particles: &'a Particles, camera: Camera) -> Shot<'a> {
        Shot { particles, camera, view: None, number: 0, depth: None }
    }

    /// What it is seen through in pictures of `size` pixels.
    pub fn seen(&self, size: [u32; 2]) -> View {
        self.view.unwrap_or_else(|| self.camera.view(size))
    }

    pub fn scene(&self) -> Scene<'a> {
        let Shot { particles, camera, view, number, depth } = *self;
        Scene { particles: Some(particles), camera, view, number, depth, rendered: true, ..Scene::default() }
    }
}

/// How a device's sums compare with the reference's, in samples: pixels times repetitions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub samples: u64,
    /// Samples with a winner.
    pub hits: u64,
    /// Samples in which rounding could make another particle win.
    pub near: u64,
    /// Pixels whose sums differ, each for one sample.
    pub differing: u64,
}

impl Tally {
    pub fn add(&mut self, other: Tally) {
        self.samples += other.samples;
        self.hits += other.hits;
        self.near += other.near;
        self.differing += other.differing;
    }

    /// At most this share of all samples differ; or one, where so few are taken that this is less.
    #[track_caller]
    pub fn assert_few(&self, name: &str, share: f64) {
        println!("{name}: {self:?}");
        assert!(self.differing as f64 <= (share * self.samples as f64).max(1.0), "{name}: {self:?}");
    }
}

pub fn control(rig: &mut FlameRig) -> Control {
    rig.offline().read_as(EffectBuffer::of::<FlameKind>(layout::CONTROL), 1).expect("the buffer can be read")[0]
}

/// Whether the frame rendered last was known to be without fire, so that the device has not looked for any.
pub fn is_dark(rig: &mut FlameRig) -> bool {
    rig.offline().effect::<FlameKind>().expect("a flame").skipped().any(|(name, _)| name == "flame.accumulate")
}

/// Tiles that something may be seen in.
pub fn occupied(rig: &mut FlameRig) -> Vec<u32> {
    let count = control(rig).tile_groups[0] as usize;
    rig.offline().read_as(EffectBuffer::of::<FlameKind>(layout::OCCUPIED_TILES), count).expect("the buffer can be read")
}

/// Those that have fire, not only such as it is smoothed or glows into.
fn burning(rig: &mut FlameRig) -> Vec<u32> {
    let settings = &rig.desc().settings;
    if !settings.is_cel() && !settings.glow.is_on() {
        return occupied(rig);
    }
    let count = rig.desc().size.map(|side| side.div_ceil(TILE)).iter().product::<u32>() as usize;
    let shown: Vec<u32> = rig
        .offline()
        .read_as(EffectBuffer::of::<FlameKind>(layout::TILE_SHOWN), count)
        .expect("the buffer can be read");
    (0..).zip(shown).filter(|(_, shown)| shown & params::BURNING != 0).map(|(tile, _)| tile).collect()
}

/// A device's sums over so many repetitions. Those of tiles without fire are never written.
pub fn sums(rig: &mut FlameRig, repetitions: u32) -> Sums {
    let [width, height] = rig.desc().size;
    let tiles_across = width.div_ceil(TILE);
    let is_occupied = {
        let tiles = if is_dark(rig) { Vec::new() } else { burning(rig) };
        move |pixel: u32| tiles.binary_search(&(pixel / width / TILE * tiles_across + pixel % width / TILE)).is_ok()
    };
    let words: Vec<[[u32; 4]; params::SUM_VECTORS as usize]> = rig
        .offline()
        .read_as(EffectBuffer::of::<FlameKind>(layout::SUMS), (width * height) as usize)
        .expect("the buffer can be read");
    let words = (0..).zip(words).map(|(pixel, words)| if is_occupied(pixel) { words } else { [[0; 4]; 4] });
    // Depths are less that.
    let base = f64::from(f32::from_bits(control(rig).base));
    let mut sums = Sums { repetitions, near: vec![0; (width * height) as usize], ..Sums::default() };
    for [low, high, square_low, square_high] in words {
        let both = |low: [u32; 4], high: [u32; 4]| [0, 1, 2].map(|c| u64::from(high[c]) << 32 | u64::from(low[c]));
        sums.light.push(both(low, high));
        sums.squares.push(both(square_low, square_high));
        sums.hits.push(low[3]);
        sums.depth.push(base * f64::from(low[3]) + f64::from(f32::from_bits(high[3])));
    }
    sums
}

/// Colour of a particle in 65535ths of the brightest.
pub fn light(particle: &params::Particle) -> [u32; 3] {
    let [rg, b] = particle.light;
    [rg & 0xFFFF, rg >> 16, b]
}

/// The reference's particles of the frame rendered last. Where the device has kept a particle, its numbers are compared and its
/// count and light taken over, so that what follows makes the same decisions; one that it has dropped keeps the
/// reference's: it must not be missed.
pub fn prepared(rig: &mut FlameRig, shot: &Shot) -> Prepared {
    let desc = rig.desc().clone();
    let rows: Vec<[f32; 4]> = shot
        .particles
        .position
        .iter()
        .zip(&shot.particles.temperature)
        .map(|([x, y, z], kelvin)| [*x, *y, *z, *kelvin])
        .collect();
    let ids = shot.particles.id.as_deref();
    let mut prepared = prepare::prepare(&desc.settings, desc.hottest, desc.seed, &shot.seen(desc.size), &rows, ids);
    let device = rig.prepared();
    let stretches = rig.stretches();
    let valid: Vec<u32> = prepared.particles.iter().map(|particle| particle.row).collect();
    let wrong = (0..).zip(&device).find(|(row, p)| p.count > 0 && valid.binary_search(row).is_err());
    assert!(wrong.is_none(), "not valid, but kept: {wrong:?}");
    for particle in &mut prepared.particles {
        let found = &device[particle.row as usize];
        if found.count > 0 {
            assert_prepared(particle, found, prepared.brightest);
            (particle.count, particle.light) = (found.count, light(found));
            if let Some(velocity) = &shot.particles.velocity {
                let velocity = velocity[particle.row as usize];
                let view = shot.seen(desc.size);
                let expected = prepare::stretch(&desc.settings, &view, desc.size, particle.centre, velocity);
                particle.stretch = stretches[particle.row as usize];
                // Halves: 11 bits of numbers below 4.
                let apart = [0, 1].map(|axis| (particle.stretch[axis] - expected[axis]).abs());
                assert!(apart[0].max(apart[1]) <= 1.5e-3, "{expected:?}: {:?}", particle.stretch);
            }
        }
    }
    prepared
}

fn assert_prepared(expected: &Particle, found: &params::Particle, brightest: f64) {
    let near = |a: f32, e: f64, tolerance: f64| (f64::from(a) - e).abs() <= tolerance;
    // A product and a quotient: 1.5 ulp.
    assert!(near(found.colour[3], expected.alpha, 2e-7 * expected.alpha), "{expected:?}: {found:?}");
    assert!(near(found.mean_count, expected.mean_count, 2e-7 * expected.mean_count), "{expected:?}: {found:?}");
    // Rounding of the mean may turn the fraction's comparison.
    let close = expected.mean_count * 2e-7;
    let counts = [-close, close].map(|by| {
        let mean = expected.mean_count + by;
        [mean.floor() as u32, mean.floor() as u32 + 1]
    });
    let doubtful = found.count != expected.count;
    assert!(!doubtful || counts.concat().contains(&found.count), "{expected:?}: {found:?}");
    assert_eq!(found.id, expected.id);
    // The specification's bound, relative to the particle's largest component.
    let largest = expected.colour.into_iter().fold(0.0, f64::max);
    let (colour, shares) = (found.colour, light(found));
    // And the table's smallest: it has logarithms of 1e-12 and more of white.
    let tolerance = 1e-4 * largest + 1e-11;
    for c in 0..3 {
        assert!(near(colour[c], expected.colour[c], tolerance), "{expected:?}: {found:?}");
        // The same of two colours, and half a step of rounding.
        let whole = if brightest > 0.0 { f64::from(params::LIGHT_STEPS) / brightest } else { 0.0 };
        let apart = (f64::from(shares[c]) - expected.colour[c] * whole).abs();
        assert!(apart <= 2.0 * tolerance * whole + 0.501, "{expected:?}: {found:?}");
    }
}

/// The mask's level, which rounding must not decide.
pub fn level(rig: &mut FlameRig, shot: &Shot, prepared: &Prepared) -> u32 {
    let nearest = if is_dark(rig) { (prepared.nearest as f32).to_bits() } else { control(rig).nearest };
    let desc = rig.desc();
    let [low, level, high] = [1.0 - 1e-6, 1.0, 1.0 + 1e-6]
        .map(|by| prepare::mask_level(&desc.settings, &shot.seen(desc.size), desc.size, prepared.nearest * by));
    assert_eq!([low, high], [level; 2], "a scene in which the level is in doubt");
    if prepared.nearest.is_finite() {
        let apart = (f64::from(f32::from_bits(nearest)) - prepared.nearest).abs();
        // A view depth of some metres in two floats' products.
        assert!(apart <= 1e-6 * prepared.nearest.max(shot.camera.eye.length()), "{apart} m");
    }
    level
}

/// The reference's sums of some repetitions of the frame rendered last.
pub fn expected(rig: &mut FlameRig, shot: &Shot, repetitions: std::ops::Range<u32>) -> Sums {
    let prepared = prepared(rig, shot);
    let level = level(rig, shot, &prepared);
    let desc = rig.desc().clone();
    let mask = Mask::new(desc.seed, desc.settings.variants);
    let frame = Frame {
        settings: &desc.settings,
        seed: desc.seed,
        number: shot.number,
        view: shot.seen(desc.size),
        size: desc.size,
        scene: shot.depth,
        mask: &mask,
        level,
        base: if is_dark(rig) { 0.0 } else { f32::from_bits(control(rig).base).into() },
    };
    render(&frame, &prepared.particles, repetitions, Rounding::default())
}

/// Compares sums: where no decision is near, all are the same, to the bit.
pub fn compare(name: &str, found: &Sums, expected: &Sums) -> Tally {
    let pixels = expected.hits.len();
    assert_eq!(found.hits.len(), pixels);
    let total = |values: &[u32]| values.iter().map(|v| u64::from(*v)).sum();
    let mut tally = Tally {
        samples: pixels as u64 * u64::from(expected.repetitions),
        hits: total(&expected.hits),
        near: total(&expected.near),
        differing: 0,
    };
    // Each addition rounds by half an ulp; each depth is off by the reference's own allowance.
    let depth_error = f64::from(expected.repetitions) * 6e-8 + Rounding::default().depth;
    for i in 0..pixels {
        let of = |sums: &Sums| (sums.light[i], sums.squares[i], sums.hits[i]);
        if of(found) != of(expected) {
            let why = format!("{:?}, expected {:?}", of(found), of(expected));
            assert!(expected.near[i] > 0, "{name}: pixel {i}, of which no decision is near: {why}");
            tally.differing += 1;
        } else if expected.near[i] == 0 {
            let apart = (found.depth[i] - expected.depth[i]).abs();
            assert!(apart <= depth_error * expected.depth[i], "{name}: pixel {i}: depth {apart} off");
        }
    }
    tally
}

/// Renders a shot and compares its sums with the reference's.
pub fn check(name: &str, rig: &mut FlameRig, shot: &Shot) -> Tally {
    rig.render(&shot.scene());
    check_rendered(name, rig, shot)
}

/// Compares the sums of the frame rendered last.
pub fn check_rendered(name: &str, rig: &mut FlameRig, shot: &Shot) -> Tally {
    let repetitions = rig.desc().settings.repetitions;
    let expected = expected(rig, shot, 0..repetitions);
    let found = sums(rig, repetitions);
    let tally = compare(name, &found, &expected);
    println!("{name}: {tally:?}");
    tally
}

/// No NaN and no infinity in any layer, but the one that means "empty".
pub fn assert_finite(name: &str, rig: &mut FlameRig) {
    let (mean, nearest) = (rig.mean(), rig.nearest());
    for (pixel, depth) in nearest.iter().enumerate() {
        let coverage = mean[pixel][3];
        assert_eq!(coverage == 0.0, *depth == f32::INFINITY, "{name}: {depth} of {coverage}");
        assert!(coverage == 0.0 || depth.is_finite() && *depth > 0.0, "{name}: {depth}");
        assert!((0.0..=1.0).contains(&coverage), "{name}: {coverage}");
    }
    let particles: Vec<params::Particle> = rig.prepared().into_iter().filter(|p| p.count > 0).collect();
    let place = |p: &params::Particle| [p.view[0], p.view[1], p.depth, p.mean_count];
    let particles = particles.iter().flat_map(|p| [place(p), p.colour]);
    let layers = [mean, rig.variance(), rig.effect(), rig.picture(), particles.collect()].concat();
    assert!(layers.as_flattened().iter().all(|v| v.is_finite()), "{name}");
    let positive = [rig.mean(), rig.variance(), rig.effect()].concat();
    assert!(positive.as_flattened().iter().all(|v| *v >= 0.0), "{name}");
}
