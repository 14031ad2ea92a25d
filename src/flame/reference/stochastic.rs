//! Repetitions: the decisions of the paper's renderer, in f64, and how many of them rounding could turn.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::draws::{Draw, Draws};
use super::mask::{Look, Mask, SIDE};
use super::octaves::Octaves;
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
    /// The view depth from where slabs of depth are counted, in metres: 0 unless the fire is far away.
    pub base: f64,
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
    /// The slab of depth of the winner, or its depth.
    slab: f64,
    /// Place in the list of particles.
    winner: usize,
    /// Nearest depth at which rounding decides.
    doubt: f64,
}

const NOTHING: Nearest = Nearest { z: f64::INFINITY, slab: f64::INFINITY, winner: usize::MAX, doubt: f64::INFINITY };

/// Slabs of depth in a repetition, in each of which the hottest wins.
#[derive(Clone, Copy, Debug)]
pub struct Slabs {
    /// Their depth in metres; 0: depths themselves.
    pub depth: f64,
    /// Where the first begins is as much before `base` as this share of a slab.
    pub begin: f64,
    /// View depth from where they are counted, in metres.
    pub base: f64,
}

impl Slabs {
    /// Of a repetition: they begin at multiples of the golden ratio.
    pub fn new(settings: &Settings, base: f64, repetition: u32) -> Slabs {
        let side = if settings.size_pixels.is_some() { settings.spread.unwrap_or_default() } else { settings.sprite() };
        let turned = repetition.wrapping_add(1).wrapping_mul(0x9E37_79B9) >> 8;
        Slabs { depth: f64::from(settings.shines() * side), begin: f64::from(turned) / 16_777_216.0, base }
    }

    /// The one that a view depth lies in; the depth without slabs.
    pub fn at(&self, z: f64) -> f64 {
        if self.depth > 0.0 { self.place(z).floor() } else { z }
    }

    fn place(&self, z: f64) -> f64 {
        (z - self.base).max(0.0) / self.depth + self.begin
    }

    /// The first and the last that it may lie in where depths, and places among slabs, are off by as much relative to themselves.
    fn around(&self, z: f64, slack: f64) -> [f64; 2] {
        let place = self.place(z);
        [-1.0, 1.0].map(|side| (place + side * slack * (z / self.depth + place)).floor())
    }
}

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
    /// The largest alpha of the mask.
    largest: f64,
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
            largest: frame.mask.largest(),
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
            let slabs = Slabs::new(self.frame.settings, self.frame.base, repetition);
            for &(index, centre) in &self.able {
                for k in 0..self.particles[index].count {
                    let draw = self.draws.draw(self.particles[index].id, k, repetition);
                    if let Some(sprite) = self.sprite(&self.particles[index], centre, &draw) {
                        self.splat(index, &sprite, &slabs, &mut nearest);
                    }
                }
            }
            self.count(&nearest, &slabs, &mut sums);
        }
        sums
    }

    fn count(&self, nearest: &[Nearest], slabs: &Slabs, sums: &mut Sums) {
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
            // What is in no farther slab than the winner could have won.
            let doubt = seen.doubt * (1.0 - self.rounding.depth);
            if seen.doubt.is_finite() && (doubt <= seen.z || slabs.at(doubt) <= seen.slab) {
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
    fn splat(&self, index: usize, sprite: &Sprite, slabs: &Slabs, nearest: &mut [Nearest]) {
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
                // Without slabs they are the same.
                if sprite.z - slack > seen.z && slabs.at(sprite.z - slack) > seen.slab {
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
                    self.meet(seen, index, sprite.z, slabs);
                }
            }
        }
    }

    /// The nearest slab wins, in it the hottest, then the nearest, then the smaller id, then the first row.
    fn meet(&self, seen: &mut Nearest, index: usize, z: f64, slabs: &Slabs) {
        let slab = slabs.at(z);
        if let Some(winner) = self.particles.get(seen.winner) {
            let own = &self.particles[index];
            // Equal light: whichever wins, the sums are the same.
            if own.light != winner.light && self.is_doubtful([(own, z), (winner, seen.z)], slabs) {
                seen.doubt = seen.doubt.min(z).min(seen.z);
            }
            let heat = |particle: &Particle| if slabs.depth > 0.0 { particle.alpha } else { 0.0 };
            let order = slab.total_cmp(&seen.slab).then(heat(winner).total_cmp(&heat(own))).then(z.total_cmp(&seen.z));
            if order.then((own.id, own.row).cmp(&(winner.id, winner.row))).is_ge() {
                return;
            }
        }
        (seen.z, seen.slab, seen.winner) = (z, slab, index);
    }

    /// Whether rounding may decide between two particles' sprites. Equal depths are equal for everyone.
    fn is_doubtful(&self, [(a, z), (b, other)]: [(&Particle, f64); 2], slabs: &Slabs) -> bool {
        let slack = self.rounding.depth;
        let close = z != other && (z - other).abs() <= slack * z.abs().max(other.abs());
        let ([low, high], [other_low, other_high]) = (slabs.around(z, slack), slabs.around(other, slack));
        match () {
            _ if slabs.depth == 0.0 || slack == 0.0 => close,
            _ if high < other_low || other_high < low => false,
            _ if [low, other_low, other_high] != [high; 3] => true,
            _ => (a.alpha - b.alpha).abs() <= self.rounding.alpha * a.alpha.max(b.alpha) && close,
        }
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
        let look = self.detailed(
            sprite,
            [u, v],
            self.frame.mask.bilinear(sprite.variant, (u + 1.0) * texels, (v + 1.0) * texels),
        );
        let uncertain = if look.empty { 0.0 } else { look.slope * texels * error + self.rounding.alpha };
        let test = self.compare(sprite.alpha, look.alpha, uncertain);
        if beyond >= 0.0 {
            Test { passes: false, can_fail: true, ..test }
        } else {
            Test { can_fail: test.can_fail || beyond >= -slack && slack > 0.0, ..test }
        }
    }

    /// With finer noise where the mask is magnified: as high as the cone, and no higher than the mask is anywhere.
    fn detailed(&self, sprite: &Sprite, [u, v]: [f64; 2], look: Look) -> Look {
        let footprint = SIDE as f64 / 2.0 / sprite.half[0].min(sprite.half[1]);
        let place = [u, v].map(|c| (c + 1.0) / 2.0 * SIDE as f64);
        let settings = self.frame.settings;
        let octaves = Octaves::new(settings.detail(), self.frame.seed, sprite.variant as u32, place, footprint);
        if octaves.slope == 0.0 {
            return look;
        }
        let cone = (1.0 - u.hypot(v)).max(0.0);
        let alpha = (look.alpha + cone * octaves.value).clamp(0.0, cone.min(self.largest));
        // The cone falls by the half side in 32 texels.
        let slope = look.slope + octaves.slope + 2.0 * (1.0 + octaves.value.abs()) / (SIDE as f64 / 2.0);
        Look { alpha, slope, empty: false }
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
mod tests;
