//! Where a vertex is within its cluster, and how far it is drawn back.

use crate::blur::mesh::Mesh;
use crate::blur::motion::{Cluster, Interval};
use crate::blur::params::{AHEAD, LEAST_EXTENT, LEAST_SPEED_SQUARED, UNIT};
use crate::blur::settings::Settings;
use crate::random::{hash, unit};
use crate::shaders::blur::constants::SMOOTHED;

/// The state of a vertex of the distorted mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// How far front it is: 0 (rear) to 1.
    pub k: f32,
    /// How far across it is: 0 to 1.
    pub l: f32,
    /// The change of k' by smoothing the seams.
    pub offset: f32,
    /// The sub-frame time at which it is drawn, in frames after frame i, `1 - strength` to `1 + lead`.
    pub time: f32,
    /// How much of strength and lead it has.
    pub share: f32,
}

impl Extent {
    /// That of a vertex that is not distorted.
    pub const NONE: Extent = Extent { k: 1.0, l: 0.0, offset: 0.0, time: 1.0, share: 1.0 };
}

/// k and l of a vertex with position and velocity `motion` among the points of its cluster: equations 3 to 6, in f32,
/// each operation rounded by itself, in this order. `points` may be all of the cluster's points or its hull.
pub fn extent(motion: [f32; 4], points: &[[f32; 2]]) -> [f32; 2] {
    let [x, y, vx, vy] = motion;
    let squared = vx * vx + vy * vy;
    // Also where the square is not a number.
    if squared.is_nan() || squared < LEAST_SPEED_SQUARED {
        return [1.0, 0.0];
    }
    let inverse = 1.0 / squared.sqrt();
    let along = [vx * inverse, vy * inverse];
    let share = |[dx, dy]: [f32; 2]| {
        let own = dx * x + dy * y;
        let (mut least, mut most) = (f32::MAX, f32::MIN);
        for point in points {
            let p = dx * point[0] + dy * point[1];
            (least, most) = (least.min(p), most.max(p));
        }
        let (n, m) = (most - own, least - own);
        if n - m < LEAST_EXTENT { None } else { Some((-m / (n - m)).clamp(0.0, 1.0)) }
    };
    [share(along).unwrap_or(1.0), share([along[1], -along[0]]).unwrap_or(0.0)]
}

/// k and l of a vertex of a cluster: in its row, or among the cluster's extreme points. In f32, each operation rounded by itself.
pub fn extent_in(motion: [f32; 4], cluster: &Cluster, bounds: &[[f32; 2]]) -> [f32; 2] {
    if !cluster.has_rows() {
        return extent(motion, bounds);
    }
    let [x, y, vx, vy] = motion;
    let squared = vx * vx + vy * vy;
    if squared.is_nan() || squared < LEAST_SPEED_SQUARED {
        return [1.0, 0.0];
    }
    let [dx, dy] = cluster.ahead;
    let aside = (dy * x - dx * y) - cluster.aside;
    let l = if cluster.width < LEAST_EXTENT { 0.0 } else { (aside / cluster.width).clamp(0.0, 1.0) };
    let last = bounds.len() - 1;
    let row = l * last as f32;
    let index = (row as usize).min(last.max(1) - 1);
    let (from, to) = (bounds[index], bounds[(index + 1).min(last)]);
    let [rear, front] = [0, 1].map(|side| from[side] + (row - index as f32) * (to[side] - from[side]));
    let length = front - rear;
    let k = if length < LEAST_EXTENT { 1.0 } else { (((dx * x + dy * y) - rear) / length).clamp(0.0, 1.0) };
    [k, l]
}

/// Rear and front of each of so many rows of a cluster, by looking at all of its points and edges for each (see
/// [`crate::blur::settings::Extent::Row`]): `points` are at these places, `edges` join them.
pub fn rows(cluster: &Cluster, points: &[[f64; 2]], edges: &[[usize; 2]], count: usize) -> Vec<[f64; 2]> {
    let [dx, dy] = cluster.ahead.map(f64::from);
    let (begin, width) = (f64::from(cluster.aside), f64::from(cluster.width));
    let spacing = if count > 1 { width / (count - 1) as f64 } else { f64::INFINITY };
    let place = |point: usize| {
        let [x, y] = points[point];
        [dx * x + dy * y, dy * x - dx * y]
    };
    let own = |row: usize| -> Option<[f64; 2]> {
        let middle = if count > 1 { begin + row as f64 * spacing } else { begin };
        let is_here = |aside: f64| (aside - middle).abs() <= 0.5 * spacing;
        let mut ahead: Vec<f64> =
            (0..points.len()).map(place).filter(|[_, aside]| is_here(*aside)).map(|[ahead, _]| ahead).collect();
        for [a, b] in edges {
            let ([from, at], [to, end]) = (place(*a), place(*b));
            for border in [middle - 0.5 * spacing, middle + 0.5 * spacing] {
                if (border - at) * (border - end) < 0.0 {
                    ahead.push(from + (border - at) / (end - at) * (to - from));
                }
            }
        }
        let [rear, front] = [f64::min, f64::max].map(|of| ahead.iter().copied().reduce(of));
        rear.zip(front).map(Into::into)
    };
    let own: Vec<Option<[f64; 2]>> = (0..count).map(own).collect();
    let filled = |row: usize| -> [f64; 2] {
        if let Some(bounds) = own[row] {
            return bounds;
        }
        let before = (0..row).rev().find_map(|row| Some((row, own[row]?)));
        let after = (row + 1..count).find_map(|row| Some((row, own[row]?)));
        let ((before, from), (after, to)) = before.zip(after).expect("the first and the last row have a point");
        let share = (row - before) as f64 / (after - before) as f64;
        [0, 1].map(|side| from[side] + share * (to[side] - from[side]))
    };
    let filled: Vec<[f64; 2]> = (0..count).map(filled).collect();
    let mean = |row: usize| {
        let far = (SMOOTHED as usize).min(row).min(count - 1 - row);
        let around = &filled[row - far..=row + far];
        [0, 1].map(|side| around.iter().map(|bounds| bounds[side]).sum::<f64>() / around.len() as f64)
    };
    (0..count).map(mean).collect()
}

/// The same in f64, as the equations are written.
pub fn extent_f64(motion: [f64; 4], points: &[[f64; 2]]) -> [f64; 2] {
    let [x, y, vx, vy] = motion;
    let speed = vx.hypot(vy);
    if speed < 1e-6 {
        return [1.0, 0.0];
    }
    let share = |ux: f64, uy: f64| {
        let products = points.iter().map(|p| ((p[0] - x) * ux + (p[1] - y) * uy) / speed);
        let [m, n] = products.fold([f64::MAX, f64::MIN], |[m, n], p| [m.min(p), n.max(p)]);
        if n - m < 1e-3 { None } else { Some((-m / (n - m)).clamp(0.0, 1.0)) }
    };
    [share(vx, vy).unwrap_or(1.0), share(vy, -vx).unwrap_or(0.0)]
}

/// R at `l`: piecewise linear through the cluster's random numbers (equation 7), from number `first` on.
pub fn tooth(seed: u32, generation: u32, cluster: &Cluster, l: f32, first: u32) -> f32 {
    let random = |q: u32| unit(hash(seed, cluster.object, first + q, generation));
    if cluster.teeth < 2 {
        return random(0);
    }
    let x = (cluster.teeth - 1) as f32 * l;
    let q = (x as u32).min(cluster.teeth - 2);
    let (from, to) = (random(q), random(q + 1));
    from + (x - q as f32) * (to - from)
}

/// What k' of the points of an interval follows from, besides k and l.
#[derive(Clone, Copy, Debug)]
pub struct Pull<'a> {
    /// The interval.
    pub interval: &'a Interval,
    /// Strength, lead and how they depend on speed.
    pub settings: &'a Settings,
    /// Lines of the picture.
    pub height: u32,
    /// Of the teeth.
    pub seed: u32,
}

impl Pull<'_> {
    /// The share of strength that what moves so fast has.
    pub fn share(&self, [vx, vy]: [f32; 2]) -> f32 {
        let speed = (vx * vx + vy * vy).sqrt();
        let keys = &self.settings.curve.keys;
        let key = |k: usize| [Settings::scaled(keys[k][0], self.height), keys[k][1]];
        let after = (0..keys.len()).take_while(|k| key(*k)[0] <= speed).count();
        match (after, keys.len()) {
            (_, 0) => 1.0,
            (0, _) => key(0)[1],
            (after, count) if after == count => key(count - 1)[1],
            (after, _) => {
                let ([from, low], [to, high]) = (key(after - 1), key(after));
                low + (speed - from) / (to - from) * (high - low)
            }
        }
    }

    /// k' of a vertex of a cluster by itself (equation 8), and what leads ahead of it.
    pub fn time(&self, cluster: &Cluster, [k, l]: [f32; 2], share: f32) -> f32 {
        let Settings { strength, lead, .. } = *self.settings;
        let random = |first| tooth(self.seed, self.interval.generation, cluster, l, first);
        let time = 1.0 - strength * share * (1.0 - k) * random(0);
        if lead == 0.0 { time } else { time + lead * share * k * random(AHEAD) }
    }

    /// k' with what smoothing adds, within the range that k' has.
    pub fn shifted(&self, time: f32, offset: f32) -> f32 {
        (time + offset).max(1.0 - self.settings.strength).min(1.0 + self.settings.lead)
    }
}

/// The extent of every point, smoothed at the seams; of `shares` of strength, which may be none: all of it.
pub fn extents(mesh: &Mesh, pull: &Pull, shares: &[f32]) -> Vec<Extent> {
    let interval = pull.interval;
    let of_point = |(point, (motion, label)): (usize, (&[f32; 4], &u32))| {
        let share = shares.get(point).unwrap_or(&1.0) * pull.share([motion[2], motion[3]]);
        let Some(cluster) = interval.cluster(*label) else { return Extent { share, ..Extent::NONE } };
        let [k, l] = extent_in(*motion, cluster, interval.bounds_of(cluster));
        Extent { k, l, offset: 0.0, time: pull.time(cluster, [k, l], share), share }
    };
    let points = interval.motion.iter().zip(&interval.labels).enumerate();
    let mut extents: Vec<Extent> = points.map(of_point).collect();
    let times: Vec<f32> = extents.iter().map(|extent| extent.time).collect();
    let Settings { lead, seam_smoothing, .. } = *pull.settings;
    for (point, offset) in smooth(mesh, &interval.seams, &times, lead, seam_smoothing) {
        let extent = &mut extents[point as usize];
        extent.offset = offset;
        extent.time = pull.shifted(extent.time, offset);
    }
    extents
}

/// The change of k' of the points of `seams` by `rounds` of smoothing: each round makes each of them the mean of itself
/// and its neighbours, all at once, if that is later: what leads stays whole. In whole numbers, so that neighbours may come
/// in any order: the nearest ones of 2^-18, of 1 + `lead` - k', which is not negative.
pub fn smooth(mesh: &Mesh, seams: &[u32], times: &[f32], lead: f32, rounds: u32) -> Vec<(u32, f32)> {
    let begin: Vec<u32> = times.iter().map(|time| ((1.0 + lead - time) * UNIT + 0.5) as u32).collect();
    let mut now = begin.clone();
    for _ in 0..rounds {
        let mean = |point: &u32| {
            let others = mesh.neighbours().of(*point as usize);
            let count = others.len() as u32 + 1;
            let sum = now[*point as usize] + others.iter().map(|other| now[*other as usize]).sum::<u32>();
            ((sum + count / 2) / count).min(now[*point as usize])
        };
        let next: Vec<u32> = seams.iter().map(mean).collect();
        seams.iter().zip(next).for_each(|(point, mean)| now[*point as usize] = mean);
    }
    let change = |p: usize| (begin[p] as i32 - now[p] as i32) as f32 * (1.0 / UNIT);
    seams.iter().map(|p| (*p, change(*p as usize))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blur::mesh::MeshInput;
    use crate::blur::settings::Curve;

    fn pull<'a>(interval: &'a Interval, settings: &'a Settings) -> Pull<'a> {
        Pull { interval, settings, height: 1080, seed: 7 }
    }

    fn cluster(teeth: u32) -> Cluster {
        Cluster { object: 3, teeth, ..bytemuck::Zeroable::zeroed() }
    }

    #[test]
    fn the_foremost_is_one_and_the_rear_zero() {
        let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let at = |x, y| extent([x, y, 5.0, 0.0], &square);
        assert_eq!(at(10.0, 0.0), [1.0, 1.0]);
        assert_eq!(at(0.0, 10.0), [0.0, 0.0]);
        assert_eq!(at(2.5, 2.5), [0.25, 0.75]);
        // u = (vy, -vx): moving down (y down), the left of the picture has l = 0.
        assert_eq!(extent([2.5, 5.0, 0.0, 1.0], &square), [0.5, 0.25]);
    }

    #[test]
    fn without_extent_or_speed_there_is_no_effect() {
        assert_eq!(extent([1.0, 2.0, 3.0, 4.0], &[[1.0, 2.0]]), [1.0, 0.0]);
        assert_eq!(extent([1.0, 2.0, 0.0, 1e-7], &[[1.0, 2.0], [5.0, 5.0]]), [1.0, 0.0]);
        let line = [[0.0, 0.0], [0.0, 8.0]];
        assert_eq!(extent([0.0, 2.0, 1.0, 0.0], &line), [1.0, 0.75]);
        assert_eq!(extent([0.0, 2.0, 0.0, 1.0], &line), [0.25, 0.0]);
        assert_eq!(extent([f32::NAN; 4], &line), [1.0, 0.0]);
    }

    #[test]
    fn teeth_are_linear_between_their_random_numbers() {
        let numbers: Vec<f32> = (0..5).map(|q| unit(hash(7, 3, q, 2))).collect();
        let at = |l| tooth(7, 2, &cluster(5), l, 0);
        for (l, number) in [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().zip(&numbers) {
            assert_eq!(at(l), *number);
        }
        assert_eq!(at(0.125), numbers[0] + 0.5 * (numbers[1] - numbers[0]));
        assert_eq!(tooth(7, 2, &cluster(1), 0.7, 0), numbers[0]);
        assert_eq!(tooth(7, 2, &cluster(2), 1.0, 0), numbers[1]);
        assert_eq!(tooth(7, 2, &cluster(2), 0.0, 3), numbers[3]);
        assert_ne!(tooth(7, 3, &cluster(5), 0.0, 0), numbers[0]);
    }

    #[test]
    fn the_front_is_not_drawn_back_and_the_rear_is_by_the_strength() {
        let interval = Interval { generation: 2, ..Interval::default() };
        let [rear, front] = [0, AHEAD].map(|first| unit(hash(7, 3, first, 2)));
        let time = |strength: f32, lead: f32, k: f32, share: f32| {
            let settings = Settings { strength, lead, ..Settings::default() };
            pull(&interval, &settings).time(&cluster(1), [k, 0.0], share)
        };
        assert_eq!(time(1.0, 0.0, 1.0, 1.0), 1.0);
        assert_eq!(time(1.0, 0.0, 0.0, 1.0), 1.0 - rear);
        assert_eq!(time(2.0, 0.0, 0.0, 1.0), 1.0 - 2.0 * rear);
        assert_eq!(time(2.0, 0.0, 0.0, 0.5), 1.0 - rear);
        assert_eq!(time(0.0, 0.0, 0.3, 1.0), 1.0);
        assert_eq!(time(1.0, 1.0, 0.5, 0.0), 1.0);
        assert_eq!(time(1.0, 0.5, 1.0, 1.0), 1.0 + 0.5 * front);
        assert_eq!(time(1.0, 0.5, 0.0, 1.0), 1.0 - rear);
        let settings = Settings { lead: 0.25, ..Settings::default() };
        let pull = pull(&interval, &settings);
        assert_eq!([pull.shifted(0.1, -0.2), pull.shifted(0.9, 0.2), pull.shifted(1.2, 0.2)], [0.0, 1.1, 1.25]);
    }

    #[test]
    fn strength_follows_speed_along_the_curve() {
        let interval = Interval::default();
        let share = |keys: &[[f32; 2]], speed: f32| {
            let settings = Settings { curve: Curve { keys: keys.to_vec() }, ..Settings::default() };
            pull(&interval, &settings).share([0.6 * speed, -0.8 * speed])
        };
        assert_eq!([share(&[], 0.0), share(&[], 500.0)], [1.0; 2]);
        assert_eq!([share(&[[8.0, 0.25]], 0.0), share(&[[8.0, 0.25]], 80.0)], [0.25; 2]);
        let keys = [[10.0, 0.0], [20.0, 1.0], [40.0, 0.5]];
        for (speed, expected) in [(0.0, 0.0), (5.0, 0.0), (15.0, 0.5), (20.0, 1.0), (30.0, 0.75), (90.0, 0.5)] {
            assert!((share(&keys, speed) - expected).abs() < 1e-6, "{speed}");
        }
    }

    #[test]
    fn smoothing_takes_the_mean_and_nothing_else_moves() {
        // A line of 5 points: 0 - 1 - 2 - 3 - 4, by triangles without area.
        let triangles = [[0, 1, 1], [1, 2, 2], [2, 3, 3], [3, 4, 4]];
        let mesh =
            MeshInput { vertices: 5, triangles: &triangles, objects: None, weld: None, normals: None, rest: None };
        let mesh = Mesh::new(&mesh).unwrap();
        let times = [1.0, 1.0, 0.25, 0.25, -0.5];
        assert_eq!(smooth(&mesh, &[1, 2], &times, 0.0, 1), [(1, 0.0), (2, 0.25)]);
        assert_eq!(smooth(&mesh, &[1, 2], &times, 0.0, 0), [(1, 0.0), (2, 0.0)]);
        // Two units among three points: the nearest whole number of units is one.
        let little = [1.0, 1.0 - 2.0 / UNIT, 1.0, 1.0, 1.0];
        assert_eq!(smooth(&mesh, &[1], &little, 0.0, 1), [(1, 1.0 / UNIT)]);
        let far: Vec<f32> = smooth(&mesh, &[1, 2, 3], &times, 0.0, 64).iter().map(|(_, offset)| *offset).collect();
        // The middle comes to lie evenly between its neighbours, which are above what is even, and stay.
        for (found, limit) in far.iter().zip([0.0, 0.375, 0.0]) {
            assert!((found - limit).abs() < 2e-5, "{far:?}");
        }
    }
}
