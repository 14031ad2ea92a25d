//! Births, motion, deaths and fades of the particles, frame by frame (section 3.1 of the paper).

use glam::DVec3;

use super::grid::Grid;
use super::{birth, detail, grow, surface};
use crate::random::{hash, unit};
use crate::shaders::smoke::constants::{BOIL_SIZE, BOIL_SIZE_OF, FIRST_AGE};
use crate::smoke::settings::{Integrator, RadiusFrom, Settings};

/// The particles of one effect. A new one starts afresh: its first [`Particles::step`] is the first frame.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    slots: Vec<Slot>,
    ghosts: Vec<Option<Ghost>>,
    frames: usize,
}

/// One particle of a constant number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slot {
    /// False where it could not be born: no voxel is a candidate.
    pub alive: bool,
    /// Was it born in this frame?
    pub newborn: bool,
    /// Does its sphere grow after birth? Those of the first frame do not.
    pub grows: bool,
    /// Frames since birth.
    pub age: u32,
    /// Births in this slot so far, which is the generation of the next one.
    pub births: u32,
    /// In metres.
    pub position: [f32; 3],
    /// Displacement into the next frame, in metres.
    pub displacement: [f32; 3],
    /// Radius in metres before `scale` and fade, of which the next one keeps a share.
    pub kept: f64,
    /// Displayed radius in metres: after `scale` and fade.
    pub radius: f64,
}

/// The remains of a particle for the `fade` frames after its death.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ghost {
    /// Frames since death.
    pub age: u32,
    /// In metres.
    pub position: [f32; 3],
    /// Displacement into the next frame, in metres.
    pub displacement: [f32; 3],
    /// The particle's last displayed radius in metres.
    pub last_radius: f64,
    /// Displayed radius in metres.
    pub radius: f64,
}

/// The state of a sphere in the frame before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Nothing: it was born in this frame, or is dead.
    Fresh,
    /// The same particle, at the same place of the list.
    Kept,
    /// The particle at this place of the list, whose ghost it is now.
    Ghost(usize),
}

impl Particles {
    /// Advances by one frame of `dt` seconds into the volume `grid`. `settings` stay the same from frame to frame.
    pub fn step(&mut self, grid: &Grid, settings: &Settings, dt: f32, seed: u32) {
        let density = detail::smoothed(grid, settings);
        let grid = &Grid { density: &density, ..*grid };
        let columns = settings.particles as usize;
        let rows = settings.fade as usize;
        let first = self.frames == 0;
        if first {
            self.slots = vec![Slot::default(); columns];
            self.ghosts = vec![None; rows * columns];
        }
        for ghost in &mut self.ghosts {
            *ghost = ghost.and_then(|ghost| ghost.moved(settings.fade));
        }
        let candidates = birth::candidates(grid, settings.threshold, settings.emitter);
        for (column, slot) in self.slots.iter_mut().enumerate() {
            slot.newborn = false;
            if slot.alive
                && let Some(ghost) = slot.live_or_die(grid, settings, dt)
            {
                // Ghosts last `rows` frames: the one that was here is gone.
                self.ghosts[self.frames % rows * columns + column] = Some(ghost);
            }
            if !slot.alive {
                let born = birth::birth(grid, settings.emitter, &candidates, seed, column as u32, slot.births);
                let age = if first { first_age(settings, seed, column as u32) } else { 0 };
                slot.be_born(born, age, !first);
            }
        }
        for (column, slot) in (0..).zip(&mut self.slots) {
            slot.displacement = displacement(grid, slot.position, settings.integrator, dt);
            slot.grow(grid, settings, first);
            slot.radius *= boiled(settings, seed, column, self.frames as u32);
        }
        for ghost in self.ghosts.iter_mut().flatten() {
            ghost.displacement = displacement(grid, ghost.position, settings.integrator, dt);
            ghost.radius = ghost.last_radius * (1.0 - ramp(ghost.age, settings.fade));
        }
        self.frames += 1;
    }

    /// The particles.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// The ring of ghosts, `fade` rows of `particles` entries: row = frame of death mod `fade`, column = slot.
    pub fn ghosts(&self) -> &[Option<Ghost>] {
        &self.ghosts
    }

    /// Centre and displayed radius in metres, slots first, then the ghosts row by row; radius 0 where there is nothing.
    pub fn spheres(&self) -> Vec<[f64; 4]> {
        let sphere = |[x, y, z]: [f32; 3], radius| [x.into(), y.into(), z.into(), radius];
        let ghost = |ghost: &Option<Ghost>| ghost.map_or([0.0; 4], |g| sphere(g.position, g.radius));
        self.slots.iter().map(|slot| sphere(slot.position, slot.radius)).chain(self.ghosts.iter().map(ghost)).collect()
    }

    /// Where each of [`Particles::spheres`] comes from.
    pub fn origins(&self) -> Vec<Origin> {
        let slot = |slot: &Slot| if slot.alive && !slot.newborn { Origin::Kept } else { Origin::Fresh };
        let ghost = |(place, ghost): (usize, &Option<Ghost>)| match ghost {
            None => Origin::Fresh,
            Some(ghost) if ghost.age == 0 => Origin::Ghost(place % self.slots.len()),
            Some(_) => Origin::Kept,
        };
        self.slots.iter().map(slot).chain(self.ghosts.iter().enumerate().map(ghost)).collect()
    }

    /// Frames since birth of each slot; none where it is dead.
    pub fn ages(&self) -> Vec<Option<u32>> {
        self.slots.iter().map(|slot| slot.alive.then_some(slot.age)).collect()
    }

    /// Generation of each slot, counted from 0; none where it is dead.
    pub fn generations(&self) -> Vec<Option<u32>> {
        self.slots.iter().map(|slot| if slot.alive { slot.births.checked_sub(1) } else { None }).collect()
    }
}

impl Slot {
    /// Moves; on death leaves a ghost if there is something to fade. A place that is not finite cannot be drawn.
    fn live_or_die(&mut self, grid: &Grid, settings: &Settings, dt: f32) -> Option<Ghost> {
        let position = sum(self.position, self.displacement);
        self.alive = survives(grid, settings, dt, position, self.age + 1);
        if self.alive {
            self.position = position;
            self.age += 1;
            return None;
        }
        let leaves_ghost = settings.fade > 0 && self.radius > 0.0 && position.iter().all(|c| c.is_finite());
        leaves_ghost.then_some(Ghost {
            age: 0,
            position,
            displacement: [0.0; 3],
            last_radius: self.radius,
            radius: self.radius,
        })
    }

    /// Starts a life at `position`; without one the slot stays dead and keeps its generation.
    fn be_born(&mut self, position: Option<[f32; 3]>, age: u32, grows: bool) {
        self.alive = position.is_some();
        self.newborn = self.alive;
        self.grows = grows;
        self.age = age;
        if let Some(position) = position {
            self.position = position;
            self.births += 1;
        }
    }

    /// While it lives, its radius keeps a share of the last frame's; it leaves the smoke by at most a quarter of a voxel.
    fn grow(&mut self, grid: &Grid, settings: &Settings, first: bool) {
        if !self.alive {
            self.radius = 0.0;
            return;
        }
        let searched = match settings.radius_from {
            RadiusFrom::Surface => surface::radius,
            RadiusFrom::Voxels => grow::radius,
        };
        let radius = searched(grid, settings.threshold, self.position, settings.radius);
        let share = if first || self.newborn { 0.0 } else { f64::from(settings.radius_smoothing) };
        let smoothed = share * self.kept + (1.0 - share) * radius;
        self.kept = smoothed.min(radius + 0.25 * grid.smallest_side());
        let fade = if self.grows { ramp(self.age, settings.fade) } else { 1.0 };
        self.radius = self.kept * f64::from(settings.scale) * fade;
    }
}

impl Ghost {
    /// The ghost one frame later, if it lasts `fade` frames.
    fn moved(self, fade: u32) -> Option<Ghost> {
        let ghost = Ghost { age: self.age + 1, position: sum(self.position, self.displacement), ..self };
        (ghost.age < fade && ghost.position.iter().all(|c| c.is_finite())).then_some(ghost)
    }
}

/// With a lifetime, particles of the first frame have lived for a while, so that they don't all end together.
fn first_age(settings: &Settings, seed: u32, slot: u32) -> u32 {
    let word = u64::from(hash(seed, slot, 0, FIRST_AGE));
    settings.lifetime.map_or(0, |lifetime| ((word * u64::from(lifetime)) >> 32) as u32)
}

/// What the radius of a slot is multiplied by in the drawing after so many others.
fn boiled(settings: &Settings, seed: u32, slot: u32, frames: u32) -> f64 {
    1.0 + f64::from(settings.boil * BOIL_SIZE) * (2.0 * f64::from(unit(hash(seed, slot, frames, BOIL_SIZE_OF))) - 1.0)
}

/// Smooth growth over `fade` frames: smoothstep((age + 1) / (fade + 1)), 1 from age `fade` on.
fn ramp(age: u32, fade: u32) -> f64 {
    let x = ((f64::from(age) + 1.0) / (f64::from(fade) + 1.0)).min(1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Does a particle of `age` frames live on at `p`? In an occupied voxel, moving (if anything does), and not too old.
fn survives(grid: &Grid, settings: &Settings, dt: f32, p: [f32; 3], age: u32) -> bool {
    let occupied = grid.cell(p).is_some_and(|[x, y, z]| grid.occupied(x, y, z, settings.threshold));
    let way = grid.velocity_at(DVec3::from(p.map(f64::from))).length() * f64::from(dt);
    let still = grid.velocity.is_some() && way <= f64::from(settings.still) * grid.smallest_side();
    occupied && !still && settings.lifetime.is_none_or(|lifetime| age < lifetime)
}

/// Displacement of a particle at `p` in `dt` seconds, in metres.
fn displacement(grid: &Grid, p: [f32; 3], integrator: Integrator, dt: f32) -> [f32; 3] {
    let (p, dt) = (DVec3::from(p.map(f64::from)), f64::from(dt));
    let velocity = match integrator {
        Integrator::Euler => grid.velocity_at(p),
        Integrator::Rk2 => grid.velocity_at(p + grid.velocity_at(p) * (dt / 2.0)),
    };
    (velocity * dt).as_vec3().to_array()
}

fn sum(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoke::settings::Emitter;

    const DENSITY: [f32; 1000] = [1.0; 1000];

    /// 10 x 10 x 10 full voxels of 1 m around the origin.
    fn grid(velocity: Option<&[[f32; 3]]>) -> Grid<'_> {
        Grid { dimensions: [10; 3], voxel_size: [1.0; 3], origin: [-5.0; 3], density: &DENSITY, velocity }
    }

    fn settings(particles: u32) -> Settings {
        let (radius_from, detail) = (RadiusFrom::Voxels, Some(0.0));
        Settings { particles, fade: 3, scale: 2.0, radius_from, detail, ..Settings::default() }
    }

    fn smoothstep(x: f64) -> f64 {
        3.0 * x * x - 2.0 * x * x * x
    }

    #[test]
    fn the_first_frame_is_full_size_and_nothing_moves_without_velocity() {
        let mut particles = Particles::default();
        particles.step(&grid(None), &settings(20), 0.04, 1);
        let first = particles.spheres();
        assert_eq!(first.len(), 20 + 3 * 20);
        for slot in particles.slots() {
            let radius = grow::radius(&grid(None), 0.1, slot.position, settings(20).radius);
            assert!(radius > 0.0 && slot.radius == 2.0 * radius);
        }
        particles.step(&grid(None), &settings(20), 0.04, 1);
        assert_eq!(particles.spheres(), first);
        assert_eq!(particles.ages(), [Some(1); 20]);
        assert_eq!(particles.generations(), [Some(0); 20]);
    }

    #[test]
    fn euler_and_midpoint_steps_in_a_rotation() {
        // v = (-y, x, 0) at voxel centres is linear, so trilinear interpolation gives it exactly.
        let centre = |i: usize| i as f32 - 4.5;
        let velocity: Vec<[f32; 3]> = (0..1000).map(|i| [-centre(i / 10 % 10), centre(i % 10), 0.0]).collect();
        let emitter = Some(Emitter { min: [0.5, 0.5, 0.0], max: [1.5, 1.5, 0.0] });
        for integrator in [Integrator::Euler, Integrator::Rk2] {
            let settings = Settings { integrator, emitter, ..settings(5) };
            let mut particles = Particles::default();
            particles.step(&grid(Some(&velocity)), &settings, 0.25, 2);
            for slot in particles.slots() {
                let [x, y, _] = slot.position.map(f64::from);
                let expected = match integrator {
                    Integrator::Euler => [-y * 0.25, x * 0.25],
                    Integrator::Rk2 => [(-y - x * 0.125) * 0.25, (x - y * 0.125) * 0.25],
                };
                // Rounded to f32 once, magnitude below 1/2.
                assert!((0..2).all(|a| (f64::from(slot.displacement[a]) - expected[a]).abs() < 3e-8));
            }
            let before = particles.slots().to_vec();
            particles.step(&grid(Some(&velocity)), &settings, 0.25, 2);
            for (old, new) in before.iter().zip(particles.slots()) {
                assert_eq!(new.position, sum(old.position, old.displacement));
            }
        }
    }

    #[test]
    fn at_the_end_of_its_life_a_particle_fades_while_its_successor_grows() {
        let settings = Settings { lifetime: Some(3), ..settings(4) };
        let full = |slot: &Slot| 2.0 * grow::radius(&grid(None), 0.1, slot.position, settings.radius);
        let mut particles = Particles::default();
        let mut shown: Vec<Vec<Slot>> = Vec::new();
        for frame in 0..12_u32 {
            particles.step(&grid(None), &settings, 0.04, 3);
            shown.push(particles.slots().to_vec());
            let origins = particles.origins();
            for (place, slot) in particles.slots().iter().enumerate() {
                // Lives end every three frames, for each slot in its own turn.
                let lived = shown[0][place].age + frame;
                assert_eq!((slot.age, slot.births), (lived % 3, 1 + lived / 3));
                let fade = if lived < 3 { 1.0 } else { smoothstep(f64::from(lived % 3 + 1) / 4.0) };
                assert!((slot.radius - full(slot) * fade).abs() < 1e-12);
                let born_now = slot.age == 0 || frame == 0;
                assert_eq!(origins[place], if born_now { Origin::Fresh } else { Origin::Kept });
                if lived < 3 {
                    continue;
                }
                // Each ghost lasts for three frames, in the row of the frame of its death.
                let died = frame - lived % 3;
                let ghost = particles.ghosts()[(died % 3) as usize * 4 + place].expect("a ghost for three frames");
                let dead = shown[died as usize - 1][place];
                assert_eq!(ghost.position, dead.position);
                let fade = 1.0 - smoothstep(f64::from(frame - died + 1) / 4.0);
                assert!((ghost.radius - dead.radius * fade).abs() < 1e-12);
                let sphere = 4 + (died % 3) as usize * 4 + place;
                assert_eq!(particles.spheres()[sphere][3], ghost.radius);
                assert_eq!(origins[sphere], if frame == died { Origin::Ghost(place) } else { Origin::Kept });
            }
        }
        let ages: Vec<u32> = shown[0].iter().map(|slot| slot.age).collect();
        assert!(ages.iter().any(|age| *age != ages[0]), "staggered: {ages:?}");
    }

    #[test]
    fn ghosts_go_to_the_row_of_their_frame_and_move_on() {
        // Everything moves by 6 m a frame along x: out of the volume at once.
        let velocity = [[6.0, 0.0, 0.0]; 1000];
        let emitter = Some(Emitter { min: [-1.0; 3], max: [1.0; 3] });
        let settings = Settings { emitter, ..settings(2) };
        let mut particles = Particles::default();
        let mut births = Vec::new();
        for frame in 0..8 {
            particles.step(&grid(Some(&velocity)), &settings, 1.0, 4);
            births.push(particles.slots()[1].position);
            for ago in 0..frame.min(3) {
                let died = frame - ago;
                let ghost = particles.ghosts()[died % 3 * 2 + 1].unwrap();
                let x = births[died - 1][0] + 6.0 * (ago + 1) as f32;
                assert_eq!(ghost.age, ago as u32);
                // Up to three roundings of numbers below 32.
                assert!((ghost.position[0] - x).abs() < 3.0 * 2.0 * f32::EPSILON * 16.0);
            }
        }
        assert_eq!(particles.generations(), [Some(7); 2]);
    }

    #[test]
    fn the_dead_wait_for_a_candidate_without_using_up_generations() {
        let empty = Grid { density: &[f32::NAN; 1000], ..grid(None) };
        let mut particles = Particles::default();
        for _ in 0..3 {
            particles.step(&empty, &settings(3), 0.04, 5);
            assert!(particles.spheres().iter().all(|s| s[3] == 0.0));
        }
        particles.step(&grid(None), &settings(3), 0.04, 5);
        assert_eq!(particles.generations(), [Some(0); 3]);
        let slot = particles.slots()[0];
        let full = 2.0 * grow::radius(&grid(None), 0.1, slot.position, settings(3).radius);
        assert!((slot.radius - full * smoothstep(0.25)).abs() < 1e-12);
        // The smoke vanishes: all die, and leave ghosts.
        particles.step(&empty, &settings(3), 0.04, 5);
        assert_eq!(particles.ages(), [None; 3]);
        assert_eq!(particles.ghosts().iter().flatten().count(), 3);
        assert_eq!(particles.slots()[0].births, 1);
        for remaining in [3, 3, 0] {
            particles.step(&empty, &settings(3), 0.04, 5);
            assert_eq!(particles.ghosts().iter().flatten().count(), remaining);
        }
    }

    #[test]
    fn still_particles_die_only_where_there_is_a_velocity_grid() {
        let ages = |speed: f32, still: f32| {
            let velocity = [[0.0, 0.0, speed]; 1000];
            let settings = Settings { still, emitter: Some(Emitter { min: [-1.0; 3], max: [1.0; 3] }), ..settings(1) };
            let mut particles = Particles::default();
            particles.step(&grid(Some(&velocity)), &settings, 0.5, 6);
            particles.step(&grid(Some(&velocity)), &settings, 0.5, 6);
            particles.ages()[0]
        };
        assert_eq!(ages(0.0, 1e-4), Some(0));
        assert_eq!(ages(0.0, 0.0), Some(0));
        assert_eq!(ages(0.5, 0.25), Some(0));
        assert_eq!(ages(0.5, 0.2), Some(1));
    }
}
