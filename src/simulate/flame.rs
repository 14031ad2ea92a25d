//! Fire in closed form: a torch of particles that are born on a disc, rise, cool and are born again.
//!
//! Where a particle is, and how hot, is a function of time alone, so any frame can be had at once. A particle belongs to
//! one of several tongues, whose heights flicker; all of them lean and fold in a turbulence that rises with the fire.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::data::{ParticleExtent, Particles};
use crate::random::{hash, unit};

/// Particles that the program makes itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Builtin {
    /// A torch of about 1 m that stands on the origin.
    Random,
}

/// How many particles there are at any time.
const PARTICLES: u32 = 2500;
/// Everything random comes from this.
const SEED: u32 = 1;
/// Seconds to both sides over which velocities are taken: their error is of its square.
const STEP: f64 = 1e-4;
/// Radius of the disc that particles are born on, in metres.
const BASE_RADIUS: f64 = 0.12;
/// Usual height of the fire in metres.
const HEIGHT: f64 = 1.05;
/// Temperature at birth and at death in kelvin.
const HOT: f64 = 3000.0;
const COLD: f64 = 900.0;
/// Mean life in seconds; a slot's own is up to a fifth shorter or longer.
const LIFE: f64 = 0.95;
/// Whole flames shed a puff so often a second: 1.5 / sqrt(diameter in metres), as measured for pool fires of any size
/// (Cetegen, Ahmed 1993).
const PUFFS: f64 = 3.1;
/// Share of the height that a puff adds or takes.
const PUFF: f64 = 0.12;
/// Share of its height by which a tongue flickers.
const LICK: f64 = 0.42;
/// Tongues around the middle, and in it.
const OUTER: u32 = 7;
const MIDDLE: u32 = 2;
/// How fast the turbulence rises, in m/s: about as fast as the fire.
const RISE: f64 = 1.2;
/// Sideways amplitude of the turbulence at the fire's usual height, in metres.
const SWAY: f64 = 0.07;
/// How strongly folds gather the fire in its upper half: 1 pulls it together in sheets with gaps between them.
const FOLD: f64 = 1.1;

/// The random draws of a particle.
#[derive(Clone, Copy)]
enum Draw {
    /// Once: how long its lives are, and when the first began.
    Life,
    Phase,
    /// In each life: its tongue, its place in the tongue's cross-section, and how high it gets.
    Tongue,
    Radius,
    Angle,
    Reach,
}

impl Builtin {
    /// The particles of that name (without `builtin:`).
    pub fn named(name: &str) -> Option<Builtin> {
        match name {
            "random" => Some(Builtin::Random),
            _ => None,
        }
    }

    /// The particles of a frame; `fps` above 0. Each life of a particle has an id of its own.
    pub fn particles(self, frame: u32, fps: f64) -> Particles {
        let time = f64::from(frame) / fps;
        let turbulence = Turbulence::new();
        let mut particles = Particles::default();
        let (mut ids, mut velocities) = (Vec::new(), Vec::new());
        for slot in 0..PARTICLES {
            let (life, age) = Life::at(slot, time);
            let (position, temperature) = life.particle(age, time, &turbulence);
            let [before, after] =
                [-STEP, STEP].map(|step| life.particle(age + step / life.span, time + step, &turbulence).0);
            particles.position.push(position.as_vec3().to_array());
            particles.temperature.push(temperature as f32);
            ids.push(life.id());
            velocities.push(((after - before) / (2.0 * STEP)).as_vec3().to_array());
        }
        Particles { id: Some(ids), velocity: Some(velocities), ..particles }
    }

    /// Bounds of the particles of every frame.
    pub fn extent(self) -> ParticleExtent {
        ParticleExtent { most: PARTICLES, hottest: HOT as f32 }
    }
}

/// A life of the particle in a slot.
struct Life {
    slot: u32,
    /// Lives are counted from 1: 0 stands for the slot itself.
    number: u32,
    /// In seconds.
    span: f64,
    tongue: Tongue,
}

impl Life {
    /// The life at a time, and the share of it that is over.
    fn at(slot: u32, time: f64) -> (Life, f64) {
        let draw = |life: u32, what: Draw| f64::from(unit(hash(SEED, slot, life, what as u32)));
        let span = LIFE * (0.8 + 0.4 * draw(0, Draw::Life));
        let lives = time / span + draw(0, Draw::Phase);
        // What is too large for 32 bits begins anew.
        let number = (lives.floor() as u64 as u32).wrapping_add(1);
        let age = lives - lives.floor();
        let tongue = Tongue::new((draw(number, Draw::Tongue) * f64::from(OUTER + MIDDLE)) as u32, time - age * span);
        (Life { slot, number, span, tongue }, age)
    }

    fn draw(&self, what: Draw) -> f64 {
        f64::from(unit(hash(SEED, self.slot, self.number, what as u32)))
    }

    fn id(&self) -> u32 {
        self.number.wrapping_mul(PARTICLES).wrapping_add(self.slot)
    }

    /// Position and temperature.
    fn particle(&self, age: f64, time: f64, turbulence: &Turbulence) -> (DVec3, f64) {
        let tongue = &self.tongue;
        // Hot gas accelerates. Few particles get to the very top.
        let share = 0.5 * (age + age * age) * (1.0 - 0.45 * self.draw(Draw::Reach).powi(3));
        let y = tongue.height * share;
        let height = y / HEIGHT;
        let away = self.draw(Draw::Radius).sqrt();
        let (sin, cos) = (TAU * self.draw(Draw::Angle)).sin_cos();
        let place = DVec3::new(cos, 0.0, sin) * away * tongue.radius * outline(share);
        let upright = tongue.axis * spread(height) + place + DVec3::Y * y;
        // The border is cooler than the core, most of all where the fire is young.
        let border = 0.30 * away.powi(3) * (4.0 * age).clamp(0.1, 1.0) * (1.0 - 0.5 * age);
        let cooled = (0.95 * age.max(0.0).powf(1.1) + border).min(1.0);
        (upright + turbulence.offset(upright, height, time), HOT + (COLD - HOT) * cooled)
    }
}

/// Radius of a tongue, of its full one, at a share of its height: a bulge, then a tapering tip.
fn outline(share: f64) -> f64 {
    (0.78 + 0.62 * bump(share, 0.24, 0.17)) * (1.0 - share).max(0.0).powf(0.65) + 0.06
}

/// How far tongues stand from the middle at a share of the fire's usual height.
fn spread(height: f64) -> f64 {
    0.75 + 0.55 * bump(height, 0.22, 0.15) - 0.05 * height.min(1.0)
}

fn bump(x: f64, centre: f64, width: f64) -> f64 {
    (-((x - centre) / width).powi(2)).exp()
}

/// A tongue as those who are born at one time know it.
struct Tongue {
    /// Where it stands on the disc.
    axis: DVec3,
    /// Its height and its full radius in metres.
    height: f64,
    radius: f64,
}

impl Tongue {
    fn new(index: u32, born: f64) -> Tongue {
        let is_middle = index >= OUTER;
        let j = f64::from(index);
        let azimuth = TAU * j / f64::from(OUTER) + 0.9 * (TAU * 0.31 * born + j).sin() + 0.35 * born;
        let flicker = 0.6 * (TAU * (2.1 + 0.37 * j) * born + 1.7 * j * j).sin()
            + 0.4 * (TAU * (3.9 + 0.23 * j) * born + 2.9 * j).sin();
        let puff = 1.0 + PUFF * (TAU * PUFFS * born).sin();
        let (height, away, radius) = if is_middle { (0.82, 0.10, 0.58) } else { (0.72, 0.62, 0.42) };
        Tongue {
            axis: DVec3::new(azimuth.cos(), 0.0, azimuth.sin()) * away * BASE_RADIUS,
            height: HEIGHT * height * puff * (1.0 + LICK * flicker),
            radius: radius * BASE_RADIUS,
        }
    }
}

/// A sine wave in space that shifts what is in it sideways.
struct Wave {
    /// Cycles per metre.
    vector: DVec3,
    phase: f64,
    /// Direction, and metres at the full amplitude.
    shift: DVec3,
}

impl Wave {
    fn at(&self, point: DVec3) -> DVec3 {
        self.shift * (TAU * self.vector.dot(point) + self.phase).sin()
    }
}

/// The turbulence of the fire. All of it rises.
struct Turbulence {
    /// Transverse waves, as of a flow without divergence: they bend the fire.
    sway: Vec<Wave>,
    /// Longitudinal waves: they gather it in sheets.
    fold: Vec<Wave>,
}

impl Turbulence {
    fn new() -> Turbulence {
        const OCTAVES: u32 = 4;
        const EACH: u32 = 3;
        const FOLDS: u32 = 4;
        let draw = |wave: u32, dimension| f64::from(unit(hash(SEED + 1, wave, 0, dimension)));
        let sway = (0..OCTAVES * EACH).map(|wave| {
            let (octave, turn) = (wave / EACH, f64::from(wave % EACH));
            let cycles = 1.1 * 1.8f64.powi(octave as i32);
            let (sin, cos) = (TAU * (turn + draw(wave, 0)) / f64::from(EACH)).sin_cos();
            let (up, along) = (0.35 + 0.5 * draw(wave, 1)).sin_cos();
            Wave {
                vector: DVec3::new(cos * along, 1.3 * up, sin * along) * cycles,
                phase: TAU * draw(wave, 2),
                shift: DVec3::new(-sin, 0.0, cos) * SWAY * 0.62f64.powi(octave as i32),
            }
        });
        let fold = (100..100 + FOLDS).map(|wave| {
            let (sin, cos) = (PI * (f64::from(wave - 100) + 0.8 * draw(wave, 0)) / f64::from(FOLDS)).sin_cos();
            let cycles = 4.6 * (1.0 + 0.5 * draw(wave, 1));
            Wave {
                vector: DVec3::new(cos * cycles, 1.3 + 0.6 * draw(wave, 2), sin * cycles),
                phase: TAU * draw(wave, 3),
                // The steepest shift that does not overtake itself, times FOLD.
                shift: DVec3::new(cos, 0.0, sin) * FOLD / (TAU * cycles),
            }
        });
        Turbulence { sway: sway.collect(), fold: fold.collect() }
    }

    /// Displacement of a point at a share `height` of the fire's usual height.
    fn offset(&self, point: DVec3, height: f64, time: f64) -> DVec3 {
        let risen = point - DVec3::Y * RISE * time;
        let sum = |waves: &[Wave]| waves.iter().map(|wave| wave.at(risen)).sum::<DVec3>();
        sum(&self.sway) * height.min(1.3) + sum(&self.fold) * ((height - 0.15) / 0.5).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use super::*;

    const FPS: f64 = 24.0;

    /// Position and temperature by id.
    fn by_id(frame: u32, fps: f64) -> HashMap<u32, (DVec3, f32)> {
        let Particles { position, temperature, id, .. } = Builtin::Random.particles(frame, fps);
        let rows = position.into_iter().map(|p| DVec3::from(p.map(f64::from))).zip(temperature);
        id.expect("ids").into_iter().zip(rows).collect()
    }

    #[test]
    fn any_frame_is_whole_and_within_the_extent() {
        let extent = Builtin::Random.extent();
        for (frame, fps) in [(0, FPS), (1, FPS), (48, FPS), (999_999, FPS), (u32::MAX, 1e-3), (7, 1e6)] {
            let particles = Builtin::Random.particles(frame, fps);
            assert_eq!(particles, Builtin::Random.particles(frame, fps));
            let Particles { position, temperature, id, .. } = particles;
            assert_eq!((position.len(), temperature.len()), (extent.most as usize, extent.most as usize));
            assert!(position.as_flattened().iter().all(|x| x.abs() < 2.0), "{frame}");
            assert!(temperature.iter().all(|t| (COLD as f32..=extent.hottest).contains(t)), "{frame}");
            if frame < 1_000_000 {
                let ids: HashSet<u32> = id.expect("ids").into_iter().collect();
                assert_eq!(ids.len(), extent.most as usize, "{frame}");
            }
        }
        assert_eq!(Builtin::Random.particles(12, FPS), Builtin::Random.particles(24, 2.0 * FPS));
    }

    #[test]
    fn it_is_a_torch() {
        for frame in (0..200).step_by(10) {
            let particles = by_id(frame, FPS);
            let mean = |low: f64, high: f64| {
                let layer = particles.values().filter(|(p, _)| (low..high).contains(&p.y));
                let layer: Vec<_> = layer.map(|(p, t)| (DVec3::new(p.x, 0.0, p.z), f64::from(*t))).collect();
                let count = layer.len() as f64;
                let axis = layer.iter().map(|(p, _)| *p).sum::<DVec3>() / count;
                let width = layer.iter().map(|(p, _)| p.distance(axis)).sum::<f64>() / count;
                (layer.len(), axis.length(), width, layer.iter().map(|(_, t)| t).sum::<f64>() / count)
            };
            let [base, belly, upper] = [mean(0.0, 0.05), mean(0.15, 0.3), mean(0.7, 0.85)];
            assert!(base.1 < 0.03 && belly.1 < 0.06 && upper.1 < 0.2, "{frame}: stands upright");
            assert!(belly.2 > base.2 && upper.2 < belly.2, "{frame}: {base:?} {belly:?} {upper:?}");
            assert!(base.3 > 2700.0 && belly.3 < 2600.0 && upper.3 < 1700.0, "{frame}: {base:?} {belly:?} {upper:?}");
            assert!(base.0 > 2 * upper.0, "{frame}: dense below");
            let top = particles.values().map(|(p, _)| p.y).fold(0.0, f64::max);
            assert!((0.8..1.4).contains(&top), "{frame}: {top}");
            let low = particles.values().filter(|(p, _)| p.y < 1e-3).map(|(p, _)| p.x.hypot(p.z));
            assert!(low.fold(0.0, f64::max) <= BASE_RADIUS, "{frame}");
        }
    }

    #[test]
    fn velocities_are_those_that_positions_have() {
        let fps = 1e4;
        let [before, now, after] = [99_999, 100_000, 100_001].map(|frame| Builtin::Random.particles(frame, fps));
        let ids = |particles: &Particles| particles.id.clone().expect("ids");
        let mut compared = 0;
        for row in 0..PARTICLES as usize {
            if ids(&before)[row] == ids(&now)[row] && ids(&now)[row] == ids(&after)[row] {
                let at = |particles: &Particles| DVec3::from(particles.position[row].map(f64::from));
                let moved = (at(&after) - at(&before)) * fps / 2.0;
                let own = DVec3::from(now.velocity.as_ref().expect("velocities")[row].map(f64::from));
                // Positions are single precision: 1e-7 m in 2e-4 s.
                assert!(own.distance(moved) < 2e-3, "{row}: {own} {moved}");
                compared += 1;
            }
        }
        assert!(compared > 2400, "{compared}");
    }

    #[test]
    fn an_id_is_one_life_of_one_particle() {
        let mut before = by_id(0, FPS);
        let mut seen: HashSet<u32> = before.keys().copied().collect();
        for frame in 1..72 {
            let now = by_id(frame, FPS);
            for (id, (p, t)) in &now {
                match before.get(id) {
                    Some((q, hotter)) => {
                        assert!(p.distance(*q) < 0.15 && p.y > q.y && t <= hotter, "{frame}: {id} {q} {p}");
                    }
                    None => assert!(seen.insert(*id) && p.y < 0.1, "{frame}: {id} is not born at the base"),
                }
            }
            // Nobody lives longer than 1.2 of the mean, so that many are born.
            let born = now.keys().filter(|id| !before.contains_key(*id)).count();
            assert!((50..200).contains(&born), "{frame}: {born}");
            before = now;
        }
    }
}
