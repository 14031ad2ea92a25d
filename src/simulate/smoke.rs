//! Smoke in closed form: a plume and a cumulus cloud of puffs that roll, with the velocity that they really have.
//!
//! Both are unions of soft balls. Where a ball is, and how large, is a function of time alone, so any frame can be had
//! at once and at any resolution. The velocity in a voxel is the mean, over the balls there, of each ball's motion to
//! the next frame: its centre's and the growth of its radius. Particles that follow it stay in the smoke.

use std::f64::consts::TAU;

use glam::{DVec3, Vec4};

use crate::data::Volume;

/// A volume that the program makes itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Builtin {
    /// A column of puffs under a rolling head, rising from the origin to about 2 m, leaning a little towards +x.
    Plume,
    /// A cumulus of about 3 m x 1.3 m, flat below, swaying in the wind and boiling.
    Cloud,
}

/// One soft ball of smoke.
#[derive(Clone, Copy, Debug)]
struct Ball {
    centre: DVec3,
    /// Metres; 0 or less: nothing there.
    radius: f64,
}

/// A ball and its motion until the next frame.
struct Moving {
    centre: DVec3,
    radius: f64,
    velocity: DVec3,
    /// Relative growth of the radius per second.
    growth: f64,
}

/// Half the width of a ball's soft border in metres.
const SOFT: f64 = 0.03;

/// Room for the plume at any time in metres, standing on the floor, centred on x = z = 0.
const PLUME_EXTENT: DVec3 = DVec3::new(1.6, 2.4, 1.6);

/// Room for the cloud.
const CLOUD_EXTENT: DVec3 = DVec3::new(3.2, 56.0 / 30.0, 64.0 / 30.0);

/// Height of the cloud's flat base in metres.
const BASE: f64 = 0.2;

impl Builtin {
    /// The volume of that name (without `builtin:`).
    pub fn named(name: &str) -> Option<Builtin> {
        match name {
            "plume" => Some(Builtin::Plume),
            "cloud" => Some(Builtin::Cloud),
            _ => None,
        }
    }

    /// The volume of a frame at its usual resolution: voxels of 1/30 m, 48 x 72 x 48 for the plume, 96 x 56 x 64 for
    /// the cloud. `fps` above 0.
    pub fn volume(self, frame: u32, fps: f64) -> Volume {
        let dimensions = match self {
            Builtin::Plume => [48, 72, 48],
            Builtin::Cloud => [96, 56, 64],
        };
        self.sampled(frame, fps, dimensions)
    }

    /// The volume of a frame with so many voxels along x, y, z, each at least 1. The voxels are the smallest cubes with
    /// which the whole of the smoke finds room.
    pub fn sampled(self, frame: u32, fps: f64, dimensions: [u32; 3]) -> Volume {
        let time = f64::from(frame) / fps;
        let step = 1.0 / fps;
        let (extent, balls, floor) = match self {
            // A floor below the volume cuts nothing.
            Builtin::Plume => (PLUME_EXTENT, moving(|at| plume(time, at), time, step), -1.0),
            Builtin::Cloud => (CLOUD_EXTENT, moving(|at| cloud(time, at), time, step), BASE),
        };
        let side = (0..3).map(|a| extent[a] / f64::from(dimensions[a].max(1))).fold(0.0, f64::max);
        let mut field = Field::new(dimensions, side);
        for ball in &balls {
            field.add(ball);
        }
        field.into_volume(floor)
    }
}

/// The balls at `time`, and where the same balls are `step` seconds later.
fn moving(balls: impl Fn(f64) -> Vec<Ball>, time: f64, step: f64) -> Vec<Moving> {
    let (now, next) = (balls(time), balls(time + step));
    let pairs = now.into_iter().zip(next).filter(|(now, _)| now.radius > 0.0);
    pairs
        .map(|(now, next)| Moving {
            centre: now.centre,
            radius: now.radius,
            velocity: (next.centre - now.centre) / step,
            growth: (next.radius.max(0.0) - now.radius) / step / now.radius.max(2.0 * SOFT),
        })
        .collect()
}

/// A number in 0 to 1 that depends on all of the three and looks random.
fn random(seed: u32, index: u32, cycle: i64) -> f64 {
    let mut state = 0u32;
    for word in [seed, index, cycle as u32] {
        // PCG's output permutation, as used for hashing.
        let s = state.wrapping_add(word).wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let w = ((s >> ((s >> 28) + 4)) ^ s).wrapping_mul(277_803_737);
        state = (w >> 22) ^ w;
    }
    f64::from(state) / f64::from(u32::MAX)
}

/// 0 up to `from`, 1 from `to` on, smooth between.
fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let u = ((x - from) / (to - from)).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// How a puff rolls: lobes come up at its top, swell, travel outwards and down its side, and sink in again.
struct Roll {
    seed: u32,
    lobes: u32,
    /// Seconds from coming up to sinking in.
    period: f64,
    /// Radius of a lobe, of the puff's.
    size: f64,
    /// Flattening of the circle of lobes: distance of their centres from the axis and along it, of the puff's radius.
    wide: f64,
    high: f64,
    /// Small lobes on each lobe.
    small: u32,
}

impl Roll {
    /// Adds the puff and its lobes at the time `at`; which lobes those are is settled by the time `key`.
    fn add(&self, balls: &mut Vec<Ball>, puff: Ball, key: f64, at: f64) {
        balls.push(puff);
        for lobe in 0..self.lobes {
            let offset = f64::from(lobe) / f64::from(self.lobes) + 0.13 * random(self.seed, lobe, -1);
            let cycle = (key / self.period + offset).floor();
            let phase = at / self.period + offset - cycle;
            let cycle = cycle as i64;
            // Golden angle: lobes that come up one after the other stand apart.
            let turn = f64::from(lobe) * 0.618_034 + 0.25 * random(self.seed, 100 + lobe, cycle);
            let (sin, cos) = (TAU * turn).sin_cos();
            let (rise, out) = (1.40 - 2.5 * phase).sin_cos();
            let normal = DVec3::new(out * cos * self.wide, rise * self.high, out * sin * self.wide);
            let full = self.size * (0.72 + 0.56 * random(self.seed, 200 + lobe, cycle));
            let swell = smoothstep(0.0, 0.35, phase) * (1.0 - smoothstep(0.72, 1.0, phase));
            let ball = Ball { centre: puff.centre + normal * puff.radius, radius: puff.radius * full * swell };
            balls.push(ball);
            self.add_small(balls, ball, normal.normalize_or(DVec3::Y), lobe, cycle);
        }
    }

    /// Small lobes around the outward side of one lobe.
    fn add_small(&self, balls: &mut Vec<Ball>, lobe: Ball, normal: DVec3, index: u32, cycle: i64) {
        let (side, up) = normal.any_orthonormal_pair();
        for small in 0..self.small {
            let name = 1000 + 16 * index + small;
            let turn = (f64::from(small) + 0.5 * random(self.seed, name, cycle)) / f64::from(self.small);
            let tilt = 0.6 + 0.6 * random(self.seed, 5000 + name, cycle);
            let (sin, cos) = (TAU * turn).sin_cos();
            let direction = normal * tilt.cos() + (side * cos + up * sin) * tilt.sin();
            let radius = lobe.radius * (0.48 + 0.20 * random(self.seed, 9000 + name, cycle));
            balls.push(Ball { centre: lobe.centre + direction * lobe.radius * 0.68, radius });
        }
    }
}

/// How far the wind has carried what is `height` metres up.
fn lean(height: f64) -> f64 {
    0.03 * height.max(0.0).powf(1.6)
}

/// The plume's balls at the time `at`; which ones there are is settled by the time `key`.
fn plume(key: f64, at: f64) -> Vec<Ball> {
    const INTERVAL: f64 = 0.27;
    const LIFE: f64 = 3.2;
    let mut balls = Vec::new();
    let height = 1.8 * (1.0 - (-(at + 0.5) / 1.2).exp());
    let head = 0.22 + 0.14 * (1.0 - (-(at + 0.5) / 1.2).exp());
    let newest = (key / INTERVAL).floor() as i64;
    for puff in newest - (LIFE / INTERVAL) as i64..=newest {
        let age = (at - puff as f64 * INTERVAL) / LIFE;
        let y = (height + 0.1) * (1.0 - (1.0 - age.clamp(0.0, 1.0)).powf(1.5)) - 0.1;
        let full = 0.12 + 0.19 * (y.max(0.0) / 2.0).powf(0.8);
        let radius = full * smoothstep(-0.05, 0.03, age) * (1.0 - smoothstep(0.85, 1.0, age));
        let turn = TAU * 0.381_966 * puff as f64 + 1.2 * age;
        let away = 0.5 * full * smoothstep(0.05, 0.5, age);
        let centre = DVec3::new(lean(y) + away * turn.cos(), y, away * turn.sin());
        let seed = puff as u32;
        Roll { seed, lobes: 6, period: 3.0, size: 0.6, wide: 0.75, high: 0.7, small: 0 }.add(
            &mut balls,
            Ball { centre, radius },
            key,
            at,
        );
    }
    let centre = DVec3::new(lean(height), height, 0.0);
    Roll { seed: 77, lobes: 14, period: 4.0, size: 0.66, wide: 0.95, high: 0.75, small: 3 }.add(
        &mut balls,
        Ball { centre, radius: head },
        key,
        at,
    );
    balls
}

/// The cloud's balls at the time `at`; which ones there are is settled by the time `key`.
fn cloud(key: f64, at: f64) -> Vec<Ball> {
    // Centre and radius of the big lobes in metres.
    const LOBES: [[f64; 4]; 8] = [
        [-0.98, 0.36, 0.05, 0.27],
        [-0.50, 0.60, -0.10, 0.40],
        [0.02, 0.70, 0.00, 0.46],
        [0.22, 1.08, -0.04, 0.36],
        [0.62, 0.52, -0.05, 0.36],
        [1.04, 0.34, 0.05, 0.24],
        [-0.20, 0.44, 0.40, 0.30],
        [0.40, 0.40, 0.36, 0.28],
    ];
    let drift = 0.15 * (0.5 * at).sin();
    let mut balls = Vec::new();
    for (seed, [x, y, z, radius]) in (500u32..).zip(LOBES) {
        let breath = 1.0 + 0.05 * (1.1 * at + f64::from(seed)).sin();
        let centre = DVec3::new(x + drift, y, z);
        Roll { seed, lobes: 9, period: 4.0, size: 0.58, wide: 0.8, high: 0.8, small: 3 }.add(
            &mut balls,
            Ball { centre, radius: radius * breath },
            key,
            at,
        );
    }
    balls
}

/// Density and velocity while balls are added.
struct Field {
    dimensions: [u32; 3],
    /// Side of a voxel in metres.
    side: f64,
    /// Corner of voxel (0, 0, 0); the volume stands centred over the world's origin.
    origin: DVec3,
    /// Product of 1 - density over the balls.
    clear: Vec<f32>,
    /// Weighted sum of velocities, and of the weights.
    momentum: Vec<[f32; 4]>,
}

impl Field {
    fn new(dimensions: [u32; 3], side: f64) -> Field {
        let [nx, ny, nz] = dimensions;
        let count = nx as usize * ny as usize * nz as usize;
        let origin = DVec3::new(f64::from(nx) * -0.5, 0.0, f64::from(nz) * -0.5) * side;
        Field { dimensions, side, origin, clear: vec![1.0; count], momentum: vec![[0.0; 4]; count] }
    }

    fn add(&mut self, ball: &Moving) {
        // Velocity reaches farther than density: look-ups at the smoke's border interpolate with voxels outside of it.
        let reach = ball.radius + (2.0 * self.side).max(3.0 * SOFT);
        // Conversions of negative numbers to usize give 0.
        let low = ((ball.centre - reach - self.origin) / self.side - 0.5).ceil();
        let high = ((ball.centre + reach - self.origin) / self.side + 0.5).floor();
        let [nx, ny, nz] = self.dimensions.map(|n| n as usize);
        for z in low.z as usize..(high.z as usize).min(nz) {
            for y in low.y as usize..(high.y as usize).min(ny) {
                for x in low.x as usize..(high.x as usize).min(nx) {
                    let centre = self.origin + (DVec3::new(x as f64, y as f64, z as f64) + 0.5) * self.side;
                    let away = centre - ball.centre;
                    let depth = ball.radius - away.length();
                    // The ball that a voxel is deepest in says how it moves: at the smoke's border the one whose border that is.
                    let weight = (1.0 - away.length_squared() / (reach * reach)).max(0.0) * (depth / SOFT).exp();
                    if weight > 0.0 {
                        let voxel = (z * ny + y) * nx + x;
                        self.clear[voxel] *= 1.0 - smoothstep(-SOFT, SOFT, depth) as f32;
                        let sum = (ball.velocity + away * ball.growth).extend(1.0) * weight;
                        let momentum = &mut self.momentum[voxel];
                        *momentum = (Vec4::from_array(*momentum) + sum.as_vec4()).to_array();
                    }
                }
            }
        }
    }

    /// The volume, cut off below `floor` (metres), where nothing sinks through.
    fn into_volume(self, floor: f64) -> Volume {
        let [nx, ny, _] = self.dimensions.map(|n| n as usize);
        let height = |voxel: usize| ((voxel / nx % ny) as f64 + 0.5) * self.side;
        let density = |(voxel, clear): (usize, &f32)| {
            (1.0 - clear) * smoothstep(floor - SOFT, floor + SOFT, height(voxel)) as f32
        };
        let velocity = |(voxel, &[x, y, z, weight]): (usize, &[f32; 4])| {
            let sinking = smoothstep(floor, floor + 4.0 * SOFT, height(voxel)) as f32;
            // Where no ball is near, nothing moves.
            let scale = if weight > 0.0 { 1.0 / weight } else { 0.0 };
            [x * scale, y.max(0.0) * scale + y.min(0.0) * scale * sinking, z * scale]
        };
        Volume {
            dimensions: self.dimensions,
            voxel_size: [self.side as f32; 3],
            origin: self.origin.as_vec3().to_array(),
            density: self.clear.iter().enumerate().map(density).collect(),
            velocity: Some(self.momentum.iter().enumerate().map(velocity).collect()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: [Builtin; 2] = [Builtin::Plume, Builtin::Cloud];

    fn voxel(volume: &Volume, point: DVec3) -> Option<usize> {
        let q = (point - DVec3::from(volume.origin.map(f64::from))) / f64::from(volume.voxel_size[0]);
        let [nx, ny, nz] = volume.dimensions.map(f64::from);
        let inside = q.cmpge(DVec3::ZERO).all() && q.cmplt(DVec3::new(nx, ny, nz)).all();
        inside.then(|| ((q.z.floor() * ny + q.y.floor()) * nx + q.x.floor()) as usize)
    }

    fn occupied(volume: &Volume) -> Vec<usize> {
        (0..volume.density.len()).filter(|&i| volume.density[i] > 0.1).collect()
    }

    fn centre(volume: &Volume, voxel: usize) -> DVec3 {
        let [nx, ny, _] = volume.dimensions.map(|n| n as usize);
        let q = DVec3::new((voxel % nx) as f64, (voxel / nx % ny) as f64, (voxel / nx / ny) as f64) + 0.5;
        DVec3::from(volume.origin.map(f64::from)) + q * f64::from(volume.voxel_size[0])
    }

    #[test]
    fn both_are_smooth_solid_and_clear_of_the_walls() {
        for which in BOTH {
            for frame in [0, 1, 24, 48, 500, u32::MAX] {
                let volume = which.volume(frame, 24.0);
                assert_eq!(volume, which.volume(frame, 24.0));
                let [nx, ny, nz] = volume.dimensions.map(|n| n as usize);
                assert_eq!(volume.density.len(), nx * ny * nz);
                assert!(volume.density.iter().all(|d| (0.0..=1.0).contains(d)));
                assert!(volume.velocity.as_ref().unwrap().as_flattened().iter().all(|v| v.abs() < 10.0));
                let full = volume.density.iter().filter(|&&d| d > 0.99).count();
                let some = occupied(&volume).len();
                assert!(2 * full > some && some > 5000, "{which:?} {frame}: {full} of {some}");
                for i in occupied(&volume) {
                    let [x, y, z] = [i % nx, i / nx % ny, i / nx / ny];
                    let wall = x == 0 || x + 1 == nx || y + 1 == ny || z == 0 || z + 1 == nz;
                    assert!(!wall, "{which:?} {frame}: smoke at voxel {x} {y} {z}");
                }
            }
        }
    }

    #[test]
    fn the_plume_rises_and_the_cloud_is_flat_below() {
        let span = |which: Builtin, frame| {
            let volume = which.volume(frame, 24.0);
            let heights = occupied(&volume).into_iter().map(|i| centre(&volume, i).y).collect::<Vec<_>>();
            let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
            (low, heights.into_iter().fold(0.0, f64::max))
        };
        let tops = [1, 12, 24, 48].map(|frame| span(Builtin::Plume, frame).1);
        assert!(tops.is_sorted() && tops[0] < 1.3 && (1.9..2.4).contains(&tops[3]), "{tops:?}");
        assert!(span(Builtin::Plume, 48).0 < 0.02);
        for frame in [1, 48] {
            // The base, half its soft border and a voxel.
            assert!((span(Builtin::Cloud, frame).0 - BASE).abs() < SOFT + 1.0 / 30.0);
        }
    }

    #[test]
    fn particles_that_follow_the_velocity_stay_inside() {
        for which in BOTH {
            let mut volume = which.volume(1, 24.0);
            let solid = occupied(&volume).into_iter().filter(|&i| volume.density[i] > 0.5);
            let mut points: Vec<DVec3> = solid.step_by(7).map(|i| centre(&volume, i)).collect();
            let start = points.clone();
            for frame in 2..=13 {
                let next = which.volume(frame, 24.0);
                points.retain_mut(|p| {
                    let v = volume.velocity.as_ref().unwrap()[voxel(&volume, *p).unwrap()];
                    *p += DVec3::from(v.map(f64::from)) / 24.0;
                    voxel(&next, *p).is_some_and(|i| next.density[i] > 0.1)
                });
                volume = next;
            }
            // Half a second. Those at the border drift out by and by: lobes sink in, and a step is a straight line.
            let outside = |left: usize| 1.0 - left as f64 / start.len() as f64;
            let moved = outside(points.len());
            let still = start.iter().filter(|&&p| voxel(&volume, p).is_some_and(|i| volume.density[i] > 0.1)).count();
            let still = outside(still);
            assert!(moved < 0.05 && moved < 0.5 * still, "{which:?}: {moved} with the smoke, {still} left behind");
        }
    }

    #[test]
    fn any_resolution_shows_the_same_smoke() {
        for which in BOTH {
            let share = |dimensions| {
                let volume = which.sampled(30, 24.0, dimensions);
                assert_eq!(volume.dimensions, dimensions);
                occupied(&volume).len() as f64 * f64::from(volume.voxel_size[0]).powi(3)
            };
            let fine = share([96; 3]);
            for dimensions in [[64, 64, 64], [48, 72, 48], [20, 15, 15], [15, 20, 15]] {
                // Voxels of a sixth of the smoke's width: the border is up to a voxel off.
                let ratio = share(dimensions) / fine;
                assert!((0.8..1.25).contains(&ratio), "{which:?} {dimensions:?}: {ratio}");
            }
            assert_eq!(which.sampled(1, 24.0, [1; 3]).density.len(), 1);
        }
    }
}
