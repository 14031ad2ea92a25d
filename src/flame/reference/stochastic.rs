//! Repetitions: the decisions of the paper's renderer, in f64, and how many of them rounding could turn.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::draws::{Draw, Draws};
use super::mask::{Mask, SIDE};
use super::prepare::Particle;
use super::sums::Sums;
use super::{drawn_back, drawn_out, enlarged, half_sides, world};
use crate::flame::settings::Settings;
use crate::threads::map;
use crate::view::{Projection, View};

/// The context of a frame besides its particles.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The look; `spread` must be given.
    pub settings: &'a Settings,
    /// Same seed, same draws.
    pub seed: u32,
    /// Number of the frame, for flicker.
    pub number: u32,
    /// What it is seen through.
    pub view: View,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// View depth of the scene a pixel, infinite where nothing is.
    pub scene: Option<&'a [f32]>,
    /// The mask.
    pub mask: &'a Mask,
    /// Its level.
    pub level: u32,
}

/// How far another's numbers may be off.
#[derive(Clone, Copy, Debug)]
pub struct Rounding {
    /// Place of a sprite, in pixels.
    pub place: f64,
    /// Alpha of the mask, and alpha relative to itself.
    pub alpha: f64,
    /// View depth, relative.
    pub depth: f64,
}

impl Default for Rounding {
    /// Generous for single precision.
    fn default() -> Self {
        Rounding { place: 1e-4, alpha: 2e-6, depth: 1e-6 }
    }
}

impl Rounding {
    /// The same numbers.
    pub const NONE: Rounding = Rounding { place: 0.0, alpha: 0.0, depth: 0.0 };
}

/// Renders `repetitions` of a frame.
pub fn render(frame: &Frame, particles: &[Particle], repetitions: Range<u32>, rounding: Rounding) -> Sums {
    let work = Work::new(frame, particles, rounding);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()) as u32;
    let each = (repetitions.end.saturating_sub(repetitions.start)).div_ceil(threads).max(1) as usize;
    let mut total = Sums::new(frame.size[0] as usize * frame.size[1] as usize);
    let starts = repetitions.clone().step_by(each);
    let parts = starts.map(|start| start..repetitions.end.min(start.saturating_add(each as u32)));
    map(parts, |part| work.repeat(part)).iter().for_each(|part| total.add(part));
    total
}

/// The state of a pixel within a repetition.
#[derive(Clone, Copy)]
struct Nearest {
    z: f64,
    /// Place in the list of particles.
    winner: usize,
    /// Nearest depth at which rounding decides.
    doubt: f64,
}

const NOTHING: Nearest = Nearest { z: f64::INFINITY, winner: usize::MAX, doubt: f64::INFINITY };

/// A render particle on the screen.
struct Sprite {
    /// Centre in pixels.
    centre: [f64; 2],
    z: f64,
    /// Half sides in pixels.
    half: [f64; 2],
    /// Share of its pixel that a sprite below one pixel fills.
    fill: f64,
    alpha: f64,
    variant: usize,
    /// Quantile of the alphas in a texel, in 65536ths.
    quantile: u32,
    /// How it is drawn out, in the picture's directions.
    stretch: DVec2,
    /// Whether rounding may put it beyond near or far.
    doubtful: bool,
}

/// Whether a sprite passes at a pixel, and what rounding could make of that.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Test {
    passes: bool,
    can_pass: bool,
    can_fail: bool,
}

impl Test {
    const FAILS: Test = Test { passes: false, can_pass: false, can_fail: true };

    /// Of what happens, and what else could.
    fn or(self, other: Test) -> Test {
        let Test { can_pass, can_fail, .. } = other;
        Test { can_pass: self.can_pass || can_pass, can_fail: self.can_fail || can_fail, ..self }
    }
}

struct Work<'a> {
    frame: &'a Frame<'a>,
    particles: &'a [Particle],
    rounding: Rounding,
    draws: Draws,
    projection: Projection,
    /// The mask's level, each texel's alphas in descending order.
    sorted: Vec<f64>,
    /// Particles that can pass, and their centres in view space.
    able: Vec<(usize, DVec3)>,
}

impl<'a> Work<'a> {
    fn new(frame: &'a Frame, particles: &'a [Particle], rounding: Rounding) -> Work<'a> {
        let projection = Projection::of_valid(&frame.view, frame.size);
        let largest = frame.mask.largest() + rounding.alpha;
        let threshold = f64::from(frame.settings.threshold);
        let can_pass = |p: &Particle| threshold <= 1.0 && p.alpha * largest * (1.0 + rounding.alpha) >= threshold;
        let able = particles.iter().enumerate().filter(|(_, p)| p.count > 0 && can_pass(p));
        Work {
            frame,
            particles,
            rounding,
            draws: Draws::new(frame.settings, frame.seed, frame.number),
            projection,
            sorted: frame.mask.sorted(frame.level),
            able: able.map(|(i, p)| (i, projection.to_view(world(p.centre)))).collect(),
        }
    }

    fn repeat(&self, repetitions: Range<u32>) -> Sums {
        let pixels = self.frame.size[0] as usize * self.frame.size[1] as usize;
        let mut sums = Sums::new(pixels);
        sums.repetitions = repetitions.end - repetitions.start;
        let mut nearest = vec![NOTHING; pixels];
        for repetition in repetitions {
            nearest.fill(NOTHING);
            for &(index, centre) in &self.able {
                for k in 0..self.particles[index].count {
                    let draw = self.draws.draw(self.particles[index].id, k, repetition);
                    if let Some(sprite) = self.sprite(&self.particles[index], centre, &draw) {
                        self.splat(index, &sprite, &mut nearest);
                    }
                }
            }
            self.count(&nearest, &mut sums);
        }
        sums
    }

    fn count(&self, nearest: &[Nearest], sums: &mut Sums) {
        for (i, seen) in nearest.iter().enumerate() {
            if let Some(winner) = self.particles.get(seen.winner) {
                for c in 0..3 {
                    let light = u64::from(winner.light[c]);
                    sums.light[i][c] += light;
                    sums.squares[i][c] += light * light;
                }
                sums.hits[i] += 1;
                sums.depth[i] += seen.z;
            }
            if seen.doubt.is_finite() && seen.doubt <= seen.z * (1.0 + self.rounding.depth) {
                sums.near[i] += 1;
            }
        }
    }

    fn sprite(&self, particle: &Particle, centre: DVec3, draw: &Draw) -> Option<Sprite> {
        let spread = f64::from(self.frame.settings.spread.unwrap_or_default());
        let offset = self.projection.axes * (spread * DVec3::from_array(draw.offset));
        let stretch = DVec2::from_array(particle.stretch);
        let view = centre + drawn_out(offset.truncate(), stretch).extend(offset.z);
        let Projection { near, far, .. } = self.projection;
        let slack = self.rounding.depth * view.z.abs();
        if !(view.z >= near - slack && view.z <= far + slack) {
            return None;
        }
        let half = half_sides(self.frame.settings, &self.projection, view.z);
        let enlarged = enlarged(half);
        Some(Sprite {
            centre: self.projection.pixel_of(view).to_array(),
            z: view.z,
            half: (half * enlarged).to_array(),
            fill: enlarged.powi(-2),
            alpha: particle.alpha,
            variant: (((draw.mask >> 16) * self.frame.mask.variants() as u32) >> 16) as usize,
            quantile: draw.mask & 0xFFFF,
            stretch: stretch * DVec2::new(1.0, -1.0),
            doubtful: slack > 0.0 && (view.z <= near + slack || view.z >= far - slack),
        })
    }

    /// Tests a sprite in every pixel that it may touch.
    fn splat(&self, index: usize, sprite: &Sprite, nearest: &mut [Nearest]) {
        let outside = sprite.z < self.projection.near || sprite.z > self.projection.far;
        let range = |axis: usize| {
            let n = f64::from(self.frame.size[axis]);
            // Of what is drawn out, the corner that reaches farthest.
            let corners = [DVec2::new(1.0, 1.0), DVec2::new(1.0, -1.0)].map(|corner| drawn_out(corner, sprite.stretch));
            let reach = corners[0][axis].abs().max(corners[1][axis].abs()) * sprite.half[axis] + self.rounding.place;
            let [low, high] = [-1.0, 1.0].map(|side| sprite.centre[axis] + side * reach);
            ((low - 0.5).ceil().clamp(0.0, n) as usize)..((high - 0.5).floor() + 1.0).clamp(0.0, n) as usize
        };
        let (columns, rows) = (range(0), range(1));
        for y in rows {
            for x in columns.clone() {
                let place = y * self.frame.size[0] as usize + x;
                let seen = &mut nearest[place];
                let slack = self.rounding.depth * sprite.z;
                if sprite.z > seen.z + slack {
                    continue;
                }
                let scene = self.frame.scene.map_or(f64::INFINITY, |scene| f64::from(scene[place]));
                if sprite.z >= scene + slack {
                    continue;
                }
                let test = self.test(sprite, [x, y].map(|c| c as f64 + 0.5));
                if !test.can_pass {
                    continue;
                }
                let at_scene = slack > 0.0 && (sprite.z - scene).abs() <= slack;
                if sprite.doubtful || at_scene || test.can_fail {
                    seen.doubt = seen.doubt.min(sprite.z);
                }
                if test.passes && !outside && sprite.z < scene {
                    self.meet(seen, index, sprite.z, slack);
                }
            }
        }
    }

    /// Nearest wins, then the smaller id, then the first row.
    fn meet(&self, seen: &mut Nearest, index: usize, z: f64, slack: f64) {
        if let Some(winner) = self.particles.get(seen.winner) {
            let own = &self.particles[index];
            // Equal light: whichever wins, the sums are the same. Equal depths are equal for everyone.
            if own.light != winner.light && z != seen.z && (z - seen.z).abs() <= slack {
                seen.doubt = seen.doubt.min(z).min(seen.z);
            }
            if z > seen.z || (z == seen.z && (own.id, own.row) >= (winner.id, winner.row)) {
                return;
            }
        }
        (seen.z, seen.winner) = (z, index);
    }

    fn test(&self, sprite: &Sprite, pixel: [f64; 2]) -> Test {
        let at = (DVec2::from_array(pixel) - DVec2::from_array(sprite.centre)) / DVec2::from_array(sprite.half);
        let at = drawn_back(at, sprite.stretch).to_array();
        let error = self.rounding.place / sprite.half[0].min(sprite.half[1]);
        // What a sprite below one pixel does not fill, and whether rounding decides that.
        let quantile = f64::from(sprite.quantile) / 65536.0;
        let slack = if sprite.fill < 1.0 { 4.0 * self.rounding.depth } else { 0.0 };
        if quantile >= sprite.fill * (1.0 + slack) {
            return Test::FAILS;
        }
        let test =
            if self.frame.level == 0 { self.magnified(sprite, at, error) } else { self.minified(sprite, at, error) };
        if quantile >= sprite.fill {
            Test { passes: false, can_fail: true, ..test }
        } else if quantile >= sprite.fill * (1.0 - slack) && slack > 0.0 {
            Test { can_fail: true, ..test }
        } else {
            test
        }
    }

    /// Level 0: a bilinear look-up inside of the disc.
    fn magnified(&self, sprite: &Sprite, [u, v]: [f64; 2], error: f64) -> Test {
        let (beyond, slack) = (u * u + v * v - 1.0, 3.0 * error);
        if beyond >= slack {
            return Test::FAILS;
        }
        let texels = SIDE as f64 / 2.0;
        let look = self.frame.mask.bilinear(sprite.variant, (u + 1.0) * texels, (v + 1.0) * texels);
        let uncertain = if look.empty { 0.0 } else { look.slope * texels * error + self.rounding.alpha };
        let test = self.compare(sprite.alpha, look.alpha, uncertain);
        if beyond >= 0.0 {
            Test { passes: false, can_fail: true, ..test }
        } else {
            Test { can_fail: test.can_fail || beyond >= -slack && slack > 0.0, ..test }
        }
    }

    /// Level 1 and above: the alpha of a quantile of the texel.
    fn minified(&self, sprite: &Sprite, at: [f64; 2], error: f64) -> Test {
        let side = (SIDE >> self.frame.level) as f64;
        let place = at.map(|c| (c + 1.0) / 2.0 * side);
        let below = 1_usize << (2 * self.frame.level);
        let index = f64::from(sprite.quantile) * below as f64 / 65536.0 / sprite.fill;
        let look = |place: [f64; 2], index: f64| {
            if place.iter().any(|c| !(0.0..side).contains(c)) || index >= below as f64 {
                return Test::FAILS;
            }
            let [column, row] = place.map(|c| c as usize);
            let texel = (sprite.variant * side as usize + row) * side as usize + column;
            let alpha = self.sorted[texel * below + index as usize];
            self.compare(sprite.alpha, alpha, if alpha > 0.0 { self.rounding.alpha } else { 0.0 })
        };
        let (shift, slack) =
            (error * side / 2.0, if sprite.fill < 1.0 { 4.0 * self.rounding.depth * index } else { 0.0 });
        let mut test = look(place, index);
        let moved = |by: f64| place.map(|c| (c + by).floor());
        if moved(shift) != moved(-shift) {
            let corners = [[-shift, -shift], [shift, -shift], [-shift, shift], [shift, shift]];
            for by in corners {
                test = test.or(look([place[0] + by[0], place[1] + by[1]], index));
            }
        }
        if (index + slack).floor() != (index - slack).floor() {
            test = test.or(look(place, (index - slack).max(0.0))).or(look(place, index + slack));
        }
        test
    }

    /// The alpha test, of a mask's value that another may have with an error.
    fn compare(&self, scale: f64, mask: f64, error: f64) -> Test {
        let threshold = f64::from(self.frame.settings.threshold);
        let alpha = scale * mask;
        let slack = scale * error + self.rounding.alpha * alpha;
        Test {
            passes: mask > 0.0 && alpha.min(1.0) >= threshold,
            can_pass: mask + error > 0.0 && threshold <= 1.0 && alpha + slack >= threshold,
            can_fail: mask - error <= 0.0 || threshold > 1.0 || alpha - slack < threshold,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flame::reference::prepare::{self, Prepared};
    use crate::flame::settings::{Colour, Sampling, Shape};
    use crate::random::{hash, unit};
    use crate::view::Camera;

    /// Looks along -z from the origin, 90 degrees.
    fn camera() -> Camera {
        Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, near: 0.1, far: 50.0, ..Camera::default() }
    }

    fn settings() -> Settings {
        Settings { spread: Some(0.0), size: Some(1.0), count: 1.0, threshold: 0.5, ..Settings::light() }
    }

    /// One variant, alpha 1 everywhere.
    fn full_mask() -> Mask {
        Mask::from_texels(vec![1.0; SIDE * SIDE])
    }

    #[derive(Clone)]
    struct Scene {
        settings: Settings,
        camera: Camera,
        size: [u32; 2],
        mask: Mask,
        level: Option<u32>,
        depth: Option<Vec<f32>>,
    }

    impl Scene {
        fn new(settings: Settings, size: [u32; 2]) -> Scene {
            Scene { settings, camera: camera(), size, mask: full_mask(), level: None, depth: None }
        }

        fn prepare(&self, positions: &[[f32; 4]]) -> Prepared {
            prepare::prepare(&self.settings, 1e6, 7, &self.camera.view(self.size), positions, None)
        }

        fn render(&self, positions: &[[f32; 4]], repetitions: Range<u32>) -> Sums {
            let (prepared, view) = (self.prepare(positions), self.camera.view(self.size));
            let level = prepare::mask_level(&self.settings, &view, self.size, prepared.nearest);
            let frame = Frame {
                settings: &self.settings,
                seed: 7,
                number: 0,
                view,
                size: self.size,
                scene: self.depth.as_deref(),
                mask: &self.mask,
                level: self.level.unwrap_or(level),
            };
            render(&frame, &prepared.particles, repetitions, Rounding::default())
        }
    }

    fn covered(sums: &Sums) -> f64 {
        sums.hits.iter().map(|h| f64::from(*h)).sum()
    }

    #[test]
    fn a_full_sprite_is_a_disc_and_corners_never_pass() {
        // Depth 1: 100 pixels a metre, so a sprite 100 pixels wide at level 0.
        let scene = Scene { level: Some(0), ..Scene::new(Settings { threshold: 0.0, ..settings() }, [201, 200]) };
        let sums = scene.render(&[[0.0, 0.0, -1.0, 3000.0]], 0..3);
        let share = covered(&sums) / 3.0 / 10_000.0;
        assert!((share - std::f64::consts::FRAC_PI_4).abs() < 1e-3, "{share}");
        assert_eq!(sums.hits.iter().max(), Some(&3));
        // Symmetric about the centre, the first and last row and column are empty.
        let at = |x: usize, y: usize| sums.hits[y * 201 + x];
        assert!((0..200).all(|y| (0..201).all(|x| at(x, y) == at(200 - x, 199 - y))));
        assert!((at(100, 50), at(100, 49), at(100, 149), at(100, 150)) == (3, 0, 3, 0));
    }

    #[test]
    fn levels_pass_the_same_share() {
        // One sprite a repetition, so that none hides another; on the last level all of it passes or none.
        let settings = Settings { spread: Some(0.3), threshold: 0.8, size: Some(0.4), ..settings() };
        let scene = Scene { mask: Mask::new(3, 16), ..Scene::new(settings, [64, 64]) };
        let covered = |level| {
            let scene = Scene { level: Some(level), ..scene.clone() };
            covered(&scene.render(&[[0.1, -0.05, -1.0, 3000.0]], 0..4000))
        };
        let finest = covered(0);
        for level in [1, 2, 4, 6] {
            assert!((covered(level) / finest - 1.0).abs() < 0.06, "{level}: {} {finest}", covered(level));
        }
    }

    #[test]
    fn sprites_below_a_pixel_pass_as_often_as_they_cover() {
        // 0.3 pixels wide, a full disc, 40,000 sprites over 32 x 32 pixels.
        let mask = Mask::from_texels(vec![1.0; SIDE * SIDE]);
        let share = mask.sorted(6).iter().sum::<f64>() / (SIDE * SIDE) as f64;
        let settings = Settings { spread: Some(0.2), shape: Shape::Cube, size: Some(0.3 / 16.0), ..settings() };
        let scene = Scene { mask, ..Scene::new(settings, [32, 32]) };
        let sums = scene.render(&[[0.0, 0.0, -1.0, 3000.0]], 0..40_000);
        let expected = 40_000.0 * share * 0.3 * 0.3;
        assert!((covered(&sums) / expected - 1.0).abs() < 0.06, "{} {expected}", covered(&sums));
    }

    #[test]
    fn the_nearest_wins_and_of_equals_the_smaller_id() {
        let settings = Settings { colour: Colour::Ramp(vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), ..settings() };
        let mut scene = Scene::new(settings, [9, 9]);
        let middle = 4 * 9 + 4;
        // Red is cold here: 750 K passes too, its alpha is 1.
        let (red, green) = ([0.0, 0.0, -2.0, 750.0], [0.0, 0.0, -1.9, 2999.0]);
        scene.settings.count = 4.0;
        let sums = scene.render(&[red, green], 0..1);
        assert_eq!((sums.light[middle], sums.hits[middle], sums.near[middle]), ([0, 65535, 0], 1, 0));
        assert_eq!((sums.depth[middle], sums.squares[middle]), (f64::from(1.9_f32), [0, 65535 * 65535, 0]));
        let at_green = [0.0, 0.0, -1.9, 750.0];
        assert_eq!(scene.render(&[at_green, green], 0..1).light[middle], [65535, 0, 0]);
        assert_eq!(scene.render(&[green, at_green], 0..1).light[middle], [0, 65535, 0]);
        assert_eq!(scene.render(&[green, at_green], 0..1).near[middle], 0);
        // Within rounding of each other: counted.
        let behind = [0.0, 0.0, -1.900_000_1, 750.0];
        assert_eq!(scene.render(&[green, behind], 0..1).near[middle], 1);
        // Unless something else is nearer.
        assert_eq!(scene.render(&[green, behind, [0.0, 0.0, -1.0, 750.0]], 0..1).near[middle], 0);
    }

    #[test]
    fn the_scene_and_the_planes_occlude() {
        let mut scene = Scene::new(settings(), [8, 4]);
        scene.depth = Some((0..32).map(|i| if i % 8 < 4 { 1.5 } else { f32::INFINITY }).collect());
        let sums = scene.render(&[[0.0, 0.0, -1.6, 3000.0]], 0..2);
        assert!((0..32).all(|i| i % 8 >= 4 || sums.hits[i] == 0));
        assert!(covered(&sums) > 0.0);
        scene.depth = Some(vec![1.6; 32]);
        let touching = scene.render(&[[0.0, 0.0, -1.6, 3000.0]], 0..1);
        assert!(touching.near.iter().sum::<u32>() > 0);
        scene.depth = None;
        for z in [-0.05, -51.0, 1.0] {
            assert_eq!(covered(&scene.render(&[[0.0, 0.0, z, 3000.0]], 0..1)), 0.0);
        }
    }

    #[test]
    fn thresholds_at_their_ends() {
        let positions = [[0.0, 0.0, -1.0, 1500.0]];
        let hits = |alpha_scale: f32, threshold: f32, mask: f64| {
            let settings = Settings { alpha_scale, threshold, count: 2.0, ..settings() };
            let scene = Scene { mask: Mask::from_texels(vec![mask; SIDE * SIDE]), ..Scene::new(settings, [16, 16]) };
            covered(&scene.render(&positions, 0..1)) > 0.0
        };
        assert!(hits(1.0, 0.0, 0.1) && !hits(1.0, 0.0, 0.0) && hits(0.0, 0.0, 0.1) && hits(1.0, -1.0, 0.1));
        assert!(hits(2.0, 1.0, 1.0) && hits(8.0, 1.0, 1.0) && !hits(1.9, 1.0, 1.0));
        assert!(!hits(8.0, 1.0 + f32::EPSILON, 1.0) && hits(0.0, f32::MIN, 1.0) && !hits(0.0, f32::MIN_POSITIVE, 1.0));
    }

    #[test]
    fn tests_near_the_threshold_are_counted() {
        let positions = [[0.0, 0.0, -1.0, 3000.0]];
        let near = |threshold: f32| {
            let settings = Settings { alpha_scale: 1.0, threshold, ..settings() };
            let scene = Scene { mask: Mask::from_texels(vec![0.5; SIDE * SIDE]), ..Scene::new(settings, [16, 16]) };
            let sums = scene.render(&positions, 0..1);
            (covered(&sums) > 0.0, sums.near.iter().sum::<u32>() > 10)
        };
        assert_eq!([0.5, 0.500_000_1, 0.499_999_9].map(near), [(true, true), (false, true), (true, true)]);
        assert_eq!([0.501, 0.499].map(|t| near(t).0), [false, true]);
    }

    fn cloud(n: u32) -> Vec<[f32; 4]> {
        let draw = |i, axis| unit(hash(2, i, 0, axis)) - 0.5;
        (0..n).map(|i| [draw(i, 0), draw(i, 1), -2.0 + draw(i, 2), 3000.0 - 2500.0 * unit(hash(2, i, 0, 3))]).collect()
    }

    #[test]
    fn parts_add_up_and_few_decisions_are_near() {
        let settings = Settings {
            spread: Some(0.1),
            size: Some(0.15),
            count: 20.0,
            threshold: 0.4,
            repetitions: 64,
            sampling: Sampling::ShuffledSobol,
            ..Settings::light()
        };
        let scene = Scene { mask: Mask::new(7, 16), ..Scene::new(settings, [160, 120]) };
        let positions = cloud(300);
        let mut parts = scene.render(&positions, 0..13);
        parts.add(&scene.render(&positions, 13..64));
        let whole = scene.render(&positions, 0..64);
        assert_eq!((&parts.light, &parts.squares, &parts.hits), (&whole.light, &whole.squares, &whole.hits));
        assert!((0.05..0.9).contains(&(covered(&whole) / 64.0 / 19_200.0)));
        let near: f64 = whole.near.iter().map(|n| f64::from(*n)).sum();
        assert!(near / covered(&whole) < 5e-3, "{near} of {}", covered(&whole));
        let (mean, coverage, variance) = (whole.mean(2.0), whole.coverage(), whole.variance(2.0));
        let depths = whole.mean_depth();
        for i in 0..mean.len() {
            assert!(mean[i][0] <= 2.0 * coverage[i] + 1e-12);
            assert!(variance[i][0] >= 0.0 && variance[i][0] <= 64.0 / 63.0);
            assert!(if coverage[i] > 0.0 { (1.3..2.7).contains(&depths[i]) } else { depths[i].is_infinite() });
        }
    }
}
