//! The table of the expected image and its look-ups in f64, with the nodes, classes and weights of the kernels.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use celfx::flame::reference::expected::{Bins, Expected, integrate};
use celfx::flame::reference::kernel::FLOOR;
use celfx::flame::reference::mask::Mask;
use celfx::flame::reference::prepare::Particle;
use celfx::flame::settings::Shape;
use celfx::low_level::flame::params::{
    FINE_MASK_PLACES, KERNEL_CLASSES, KERNEL_DEPTHS, KERNEL_PLACES, MASK_PLACES, NARROW,
};
use glam::{DMat3, DVec2, DVec3};

use crate::cases::{self, Case, SIDE};
use crate::common::flame::FlameRig;

const PLACES: usize = KERNEL_PLACES as usize;
const DEPTHS: usize = KERNEL_DEPTHS as usize;
/// Along a side of the mask, at least; where the space is as narrow as two of them.
const PLACES_OF_MASK: [usize; 2] = [MASK_PLACES as usize, FINE_MASK_PLACES as usize];
const LAST: f64 = (PLACES - 1) as f64;

/// What is the same for all particles of a frame.
#[derive(Clone, Debug, PartialEq)]
struct Space {
    spread: f64,
    /// How far render particles go in depth.
    depth: f64,
    sprite: f64,
    cube: bool,
    rotation: DMat3,
}

impl Space {
    fn new(case: &Case) -> Space {
        let settings = &case.desc.settings;
        let (spread, cube) = (f64::from(settings.spread.unwrap_or_default()), settings.shape == Shape::Cube);
        let depth = if cube { spread * 3.0_f64.sqrt() } else { spread };
        Space { spread, depth, sprite: settings.sprite().into(), cube, rotation: case.projection().axes }
    }

    fn reach(&self) -> f64 {
        self.depth + 0.5 * self.sprite
    }

    /// Depths between which a ray along the view axis is within the space of a radius; the first is larger if none.
    fn chord(&self, at: DVec2, radius: f64) -> [f64; 2] {
        if self.cube {
            let back = self.rotation.transpose();
            let (across, forward) = (back * at.extend(0.0), back * DVec3::Z);
            let mut range = [-1e30, 1e30];
            for axis in 0..3 {
                let along = if forward[axis].abs() < 1e-6 { 1e-6 } else { forward[axis] };
                let ends = [-radius, radius].map(|side| (side - across[axis]) / along);
                range = [f64::max(range[0], ends[0].min(ends[1])), f64::min(range[1], ends[0].max(ends[1]))];
            }
            return range;
        }
        let rest = radius * radius - at.length_squared();
        let half = if rest > 0.0 { rest.sqrt() } else { -1.0 };
        [-half, half]
    }

    /// ln(1 - G) at all nodes of a class, of whose mask's texels these shares pass.
    fn nodes(&self, shares: &[f64]) -> Vec<f64> {
        let side = shares.len().isqrt();
        let is_thin = self.spread < 2.0 * self.sprite / PLACES_OF_MASK[0] as f64;
        let places = (PLACES_OF_MASK[usize::from(is_thin)] / side).max(1);
        let across = side * places;
        let place_side = self.sprite / across as f64;
        let widest = self.spread.max(2.0 * place_side);
        let radius = if self.cube { self.spread + 1e-12 } else { widest };
        let volume = if self.cube { 8.0 } else { 4.0 / 3.0 * std::f64::consts::PI } * radius.powi(3);
        let squeeze = self.depth / if self.cube { self.depth.max(1e-12) } else { widest };
        let weight = place_side * place_side / volume / squeeze.max(1e-12);
        let place = |i: usize| ([i % across, i / across], shares[i / across / places * side + i % across / places]);
        let passing_places: Vec<_> = (0..across * across).map(place).filter(|(_, share)| *share > 0.0).collect();
        let mut nodes = Vec::with_capacity(PLACES * PLACES * DEPTHS);
        for place in 0..PLACES * PLACES {
            let m = [place % PLACES, place / PLACES].map(|i| self.reach() * (2.0 * i as f64 / LAST - 1.0));
            let mut g = [0.0; DEPTHS];
            for (at, share) in passing_places.iter() {
                let u = at.map(|i| (i as f64 + 0.5) / across as f64 - 0.5);
                // The mask's rows go down, space goes up.
                let at = DVec2::new(m[0] - self.sprite * u[0], -(m[1] - self.sprite * u[1]));
                let [start, end] = self.chord(at, radius).map(|z| z * squeeze);
                let length = (end - start).max(0.0);
                if length > 0.0 {
                    for (k, g) in g.iter_mut().enumerate() {
                        let depth = self.depth * (2.0 * k as f64 / (DEPTHS - 1) as f64 - 1.0);
                        *g += share * (depth - start).clamp(0.0, length);
                    }
                }
            }
            nodes.extend(g.map(|g| (-(weight * g).min(1.0 - 1e-30)).ln_1p().max(FLOOR)));
        }
        nodes
    }
}

/// Nodes of the classes of a space, by the bits of the shares that they were made of.
type Known = HashMap<Vec<u64>, Arc<Vec<f64>>>;

thread_local! {
    /// Those of the last space: tests render a scene several times, and nodes take longest of all.
    static KNOWN: RefCell<(Option<Space>, Known)> = RefCell::default();
}

/// Nodes of these classes, each of whose mask's texels these shares pass.
fn tables(space: &Space, shares: &[Vec<f64>]) -> Vec<Arc<Vec<f64>>> {
    // Only a cube looks different when the camera turns.
    let rotation = if space.cube { space.rotation } else { DMat3::IDENTITY };
    let space = Space { rotation, ..space.clone() };
    KNOWN.with_borrow_mut(|(known_space, known)| {
        if known_space.as_ref() != Some(&space) {
            known.clear();
        }
        let key = |shares: &[f64]| shares.iter().map(|share| share.to_bits()).collect::<Vec<u64>>();
        let new: Vec<_> = shares.iter().filter(|shares| !known.contains_key(&key(shares))).collect();
        std::thread::scope(|scope| {
            let space = &space;
            let built: Vec<_> = new.into_iter().map(|own| (key(own), scope.spawn(move || space.nodes(own)))).collect();
            known.extend(built.into_iter().map(|(key, nodes)| (key, Arc::new(nodes.join().expect("a table")))));
        });
        let tables = shares.iter().map(|shares| Arc::clone(&known[&key(shares)])).collect();
        *known_space = Some(space);
        tables
    })
}

/// How many of the values of all variants pass in each texel of a level.
fn passing(sorted: &[f64], level: u32, threshold: f32) -> Vec<u32> {
    let texels = (SIDE >> level).pow(2);
    let mut counts = vec![0; texels];
    for (block, values) in sorted.chunks(1 << (2 * level)).enumerate() {
        let passes = |alpha: &&f64| **alpha > 0.0 && **alpha >= f64::from(threshold);
        counts[block % texels] += values.iter().filter(passes).count() as u32;
    }
    counts
}

/// A particle's class, and how many of the class its render particles are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighed {
    pub class: usize,
    pub weight: f64,
    /// If it is narrower than a pixel: then no table is needed.
    below: Option<Narrow>,
}

/// What is narrower than a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Narrow {
    /// Side of a pixel at its depth, in metres.
    pixel: f64,
    /// How often a sprite passes at its pixel.
    chance: f64,
}

/// The whole of it for a frame.
struct Model<'a> {
    case: &'a Case,
    space: Space,
    tables: Vec<Arc<Vec<f64>>>,
    weighed: Vec<Weighed>,
    /// Centres in view space.
    views: Vec<DVec3>,
    particles: &'a [Particle],
}

impl<'a> Model<'a> {
    /// Of the device's mask and particles.
    fn new(case: &'a Case, mask: &Mask, level: u32, particles: &'a [Particle]) -> Model<'a> {
        let space = Space::new(case);
        let settings = &case.desc.settings;
        // As the effect makes it: in single precision, as classes and thresholds are below.
        let largest = (Mask::new(case.desc.seed, settings.variants).largest() * 1.000001) as f32;
        // Evenly in alpha, from where nothing passes to that of the hottest.
        let lowest = 1.0 / largest.max(1e-6);
        let highest = if settings.threshold > 0.0 { (settings.alpha_scale / settings.threshold).min(1e6) } else { 1e6 };
        let highest = highest.max(lowest);
        let of_class = |class: usize| {
            let share = class as f32 / (KERNEL_CLASSES - 1) as f32;
            1.0 / (lowest * (1.0 - share) + highest * share)
        };
        let last = mask.sorted(6);
        let all = |threshold: f32| passing(&last, 6, threshold)[0];
        let projection = case.projection();
        let position = |p: &Particle| DVec3::from_array(p.centre.map(f64::from));
        let views: Vec<DVec3> = particles.iter().map(|p| projection.to_view(position(p))).collect();
        let pixel = projection.focal.min_element().recip();
        let weigh = |(particle, view): (&Particle, &DVec3)| {
            let threshold = match particle.alpha > 0.0 {
                true => settings.threshold / particle.alpha as f32,
                false if settings.threshold <= 0.0 => 0.0,
                false => 2.0,
            };
            let place = (1.0 / threshold.max(1e-30) - lowest) / (highest - lowest).max(1e-6);
            let last_class = (KERNEL_CLASSES - 1) as f32;
            let class = ((place * last_class).clamp(1.0, last_class) + 0.5) as usize;
            let share = f64::from(all(threshold)) / f64::from(all(of_class(class)).max(1));
            let pixel = pixel * projection.widening(view.z);
            let fill = (space.sprite / pixel).clamp(0.0, 1.0).powi(2);
            let below = (space.reach() < f64::from(NARROW) * pixel)
                .then(|| Narrow { pixel, chance: fill * f64::from(all(threshold)) / last.len() as f64 });
            let weight = f64::from(particle.count) * if below.is_some() { 1.0 } else { share };
            Weighed { class, weight, below }
        };
        let weighed: Vec<Weighed> = particles.iter().zip(&views).map(weigh).collect();
        let level = level.max(1);
        let sorted = mask.sorted(level);
        let below = f64::from(settings.variants << (2 * level));
        let mut used: Vec<usize> =
            particles.iter().zip(&weighed).filter(|(p, _)| p.count > 0).map(|p| p.1.class).collect();
        used.sort_unstable();
        used.dedup();
        let shares = |class: &usize| {
            passing(&sorted, level, of_class(*class)).into_iter().map(|n| f64::from(n) / below).collect::<Vec<f64>>()
        };
        let shares: Vec<_> = used.iter().map(shares).collect();
        let mut tables = vec![Arc::default(); KERNEL_CLASSES as usize];
        used.into_iter().zip(self::tables(&space, &shares)).for_each(|(class, nodes)| tables[class] = nodes);
        Model { case, space, tables, weighed, views, particles }
    }

    /// The image.
    fn render(&self, bins: Bins) -> Expected {
        let mask = Mask::from_texels(vec![0.0; SIDE * SIDE]);
        let near = self.case.projection().near;
        integrate(&self.case.frame(&mask, 0), self.particles, bins, |index, slope, borders, depths| {
            for (depth, ends) in depths.iter_mut().zip(borders.windows(2)) {
                *depth = self.optical(index, slope, [ends[0].max(near), ends[1].max(near)]);
            }
            true
        })
    }

    /// Optical depth of a particle between two view depths along a ray.
    fn optical(&self, index: usize, slope: DVec2, bin: [f64; 2]) -> f64 {
        let (view, weighed) = (self.views[index], &self.weighed[index]);
        let radius = self.space.depth;
        let zeta = bin.map(|z| (z - view.z).clamp(-radius, radius));
        let projection = self.case.projection();
        let centre = projection.widening(view.z) * slope - view.truncate();
        // Parallel rays do not slant.
        let slope = if projection.is_orthographic { DVec2::ZERO } else { slope };
        // What is drawn out lies where the table has it before.
        let w = DVec2::from_array(self.particles[index].stretch);
        let [centre, slope] = [centre, slope].map(|way| way - w * (w.dot(way) / (1.0 + w.length_squared())));
        if bin[0] >= bin[1] {
            return 0.0;
        }
        let near = projection.near - view.z;
        if let Some(narrow) = weighed.below {
            let x = self.narrow(narrow, centre, [zeta[0], zeta[1], near]);
            return weighed.weight * -(-x).ln_1p();
        }
        let [a, b] = zeta.map(|z| z / radius.max(1e-12));
        let (inner, volume) = (1.0 - (a * a + b * b) / 2.0, 1.0 - (a * a + a * b + b * b) / 3.0);
        let share = self.space.sprite / (self.space.sprite + radius);
        let middle = 0.5 * (zeta[0] + zeta[1]) * (1.0 - share + share * (inner + 1e-6) / (volume + 1e-6));
        let place = self.place(centre + middle * slope);
        let outside = place.min_element() < 0.0 || place.max_element() > LAST;
        if outside {
            return 0.0;
        }
        let depths = zeta.map(|z| (z / radius.max(1e-12) * 0.5 + 0.5) * (DEPTHS - 1) as f64);
        let ends = depths.map(|depth| self.logarithm(weighed.class, place, depth));
        let passed = self.passed(weighed, centre, slope, zeta[0]);
        let mut x = (ends[0] - passed).exp() * -(-(ends[0] - ends[1]).max(0.0)).exp_m1();
        if near > -radius {
            let missing = -self.passed(weighed, centre, slope, near.min(radius)).exp_m1();
            x /= 1.0 + (-passed).exp() * missing;
        }
        (weighed.weight * -(-x.clamp(0.0, 1.0 - 1e-30)).ln_1p()).min(127.0)
    }

    /// What has passed before a depth, at the grid's place next to the middle of the cap before it.
    fn passed(&self, weighed: &Weighed, centre: DVec2, slope: DVec2, zeta: f64) -> f64 {
        let radius = self.space.depth;
        let depth = zeta / radius.max(1e-12);
        let share = 1.0 - depth;
        let before = -0.75 * share * share / (1.0 + share) * radius;
        let place = self.place(centre + before * slope).clamp(DVec2::ZERO, DVec2::splat(LAST));
        self.logarithm(weighed.class, (place + 0.5).floor(), (depth * 0.5 + 0.5) * (DEPTHS - 1) as f64)
    }

    /// Rise of G between two depths over what is left, of a particle that needs no table; the third is the near plane's.
    fn narrow(&self, Narrow { pixel, chance }: Narrow, centre: DVec2, depths: [f64; 3]) -> f64 {
        let half = self.space.sprite.max(pixel) / 2.0;
        let blur = (0.775 * self.space.spread).max(1e-4 * pixel);
        let share = centre.to_array().map(|c| ((half + blur - c.abs()) / (2.0 * blur)).clamp(0.0, 1.0));
        let q = chance * share[0] * share[1];
        let [start, end, near] = depths.map(|zeta| {
            let share = (zeta / self.space.depth * 0.5 + 0.5).clamp(0.0, 1.0);
            q * share * share * (3.0 - 2.0 * share)
        });
        (end - start) / (1.0 - (start - near))
    }

    fn place(&self, offset: DVec2) -> DVec2 {
        (DVec2::new(offset.x, -offset.y) / self.space.reach() * 0.5 + 0.5) * LAST
    }

    /// Between the eight nodes around a place and a depth of the grid.
    fn logarithm(&self, class: usize, place: DVec2, depth: f64) -> f64 {
        let low = [place.x, place.y].map(|c| (c as usize).min(PLACES - 2));
        let (f, g) = (place - DVec2::new(low[0] as f64, low[1] as f64), (depth as usize).min(DEPTHS - 2));
        let t = depth - g as f64;
        let node = |x: usize, y: usize| {
            let first = ((low[1] + y) * PLACES + low[0] + x) * DEPTHS + g;
            let row = &self.tables[class][first..first + 2];
            row[0] + (row[1] - row[0]) * t
        };
        let (upper, lower) =
            (node(0, 0) + (node(1, 0) - node(0, 0)) * f.x, node(0, 1) + (node(1, 1) - node(0, 1)) * f.x);
        upper + (lower - upper) * f.y
    }
}

/// The device's frame, and the model's of the same mask, particles and bins.
pub fn both(case: &Case) -> Option<(FlameRig, Vec<Weighed>, Expected)> {
    let mut rig = FlameRig::new(case.desc.clone())?;
    let (weighed, image) = modelled(case, &mut rig);
    Some((rig, weighed, image))
}

/// The same of an effect that may have rendered other frames before.
pub fn modelled(case: &Case, rig: &mut FlameRig) -> (Vec<Weighed>, Expected) {
    case.render_by(rig);
    let (mask, particles, level) = (cases::device_mask(rig), cases::prepared(case, rig), cases::level(case, rig));
    let bins = cases::bins(rig);
    let model = Model::new(case, &mask, level, &particles);
    let image = model.render(bins);
    (model.weighed, image)
}
