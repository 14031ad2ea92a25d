//! Points that move, and what divisions of them are made with.

use super::trace::Traces;

/// Units of a direction: 2^20 a unit vector's length.
const DIRECTION_UNIT: f64 = 1_048_576.0;
/// Units of a position or velocity: 2^16 a pixel.
const PIXEL_UNIT: f64 = 65_536.0;
/// The largest position or velocity in units, 2^40: 16 million pixels. What is farther counts as there.
const FARTHEST_PLACE: f64 = 1_099_511_627_776.0;
/// Speeds below this, in pixels per frame, have no direction either.
const NO_SPEED: f64 = 1e-6;

/// A point that moves, in whole numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mover {
    /// Its number in the mesh.
    pub(super) point: u32,
    /// Direction of motion: of the velocity, or of the displacement where that is 0.
    pub(super) direction: [i64; 2],
    /// Position x, y and velocity x, y.
    pub(super) place: [i64; 4],
}

impl Mover {
    pub(super) fn new(point: u32, traces: Traces) -> Mover {
        let motion = traces.motion[point as usize].map(f64::from);
        let [mut x, mut y] = [motion[2], motion[3]];
        if x.hypot(y) < NO_SPEED {
            [x, y] = traces.moves[point as usize].map(f64::from);
        }
        let length = x.hypot(y);
        Mover {
            point,
            direction: [x, y].map(|c| (c / length * DIRECTION_UNIT).round() as i64),
            place: motion.map(|c| (c * PIXEL_UNIT).round().clamp(-FARTHEST_PLACE, FARTHEST_PLACE) as i64),
        }
    }

    pub(super) fn speed(&self) -> f64 {
        (self.place[2] as f64).hypot(self.place[3] as f64)
    }
}

/// Sets of numbers that are joined two by two.
#[derive(Clone, Debug, Default)]
pub(super) struct Joined {
    parent: Vec<u32>,
}

impl Joined {
    /// Becomes so many sets of one number each.
    pub(super) fn part(&mut self, count: usize) {
        self.parent.clear();
        self.parent.extend(0..count as u32);
    }

    /// The smallest number of the set of `i`.
    pub(super) fn root(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

/// What movers are sorted in.
#[derive(Clone, Debug, Default)]
pub(super) struct Sorting {
    keyed: Vec<(f64, u32)>,
    sorted: Vec<Mover>,
}

impl Sorting {
    /// Sorts movers by a value of theirs, and divides them where that leaves the least variance within the two parts
    /// (Otsu). The number of movers in the first part, and the share of the variance that is between the parts. `None` if
    /// all values are equal.
    pub(super) fn otsu(&mut self, movers: &mut [Mover], value: impl Fn(&Mover) -> f64) -> Option<(usize, f64)> {
        let Sorting { keyed, sorted } = self;
        keyed.clear();
        keyed.extend(movers.iter().map(value).zip(0..));
        keyed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        sorted.clear();
        sorted.extend(keyed.iter().map(|(_, place)| movers[*place as usize]));
        movers.copy_from_slice(sorted);
        let count = keyed.len() as f64;
        let mean = keyed.iter().map(|(value, _)| value).sum::<f64>() / count;
        let total: f64 = keyed.iter().map(|(value, _)| (value - mean) * (value - mean)).sum();
        let (mut sum, mut best) = (0.0, None);
        for (i, pair) in keyed.windows(2).enumerate() {
            sum += pair[0].0 - mean;
            let first = (i + 1) as f64;
            // The sum of all differences from the mean is 0, so that of the second part is the negative.
            let between = sum * sum * count / (first * (count - first));
            if pair[0].0 < pair[1].0 && best.is_none_or(|(_, most)| between > most) {
                best = Some((i + 1, between));
            }
        }
        best.map(|(place, between)| (place, between / total))
    }
}
