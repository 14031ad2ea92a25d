//! Front and rear of a cluster, row by row across its motion: what leads in its own row leads, also where another row leads more.
//!
//! A cluster's surface is its points and the edges between them. Rows stand side by side across the cluster's direction, from its
//! first point to its last, at most [`ROW`] apart; each has the foremost and the rearmost place of the surface that is nearer to
//! it than to the others, and one with none what lies between those beside it. Front and rear are means over [`SMOOTHED`] rows to
//! both sides, as many to each as there are, so that they do not jump where something sticks out, and linear between rows.

use crate::blur::mesh::Mesh;
use crate::blur::params::LEAST_EXTENT;
use crate::shaders::blur::constants::SMOOTHED;

/// From a row to the next, in pixels at 1080 lines, at most: a quarter of a tooth as it is by default.
pub(in crate::blur) const ROW: f32 = 3.0;
/// Rows that clusters have together beyond two a point.
pub(super) const SHARED: usize = 4096;

/// Rows and extreme points that the clusters of so many points have together, at most.
pub fn most_bounds(points: u32) -> u64 {
    2 * u64::from(points) + SHARED as u64
}

/// What rows are found of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task<'a> {
    pub(super) mesh: &'a Mesh,
    /// Position and velocity of each point.
    pub(super) motion: &'a [[f32; 4]],
    /// Cluster of each point.
    pub(super) labels: &'a [u32],
    /// Label and number of the cluster's points.
    pub(super) members: &'a [(u32, u32)],
    /// The cluster's direction, of length 1.
    pub(super) ahead: [f32; 2],
}

/// Where rows are, along the cluster's direction turned by a quarter, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Across {
    /// The first.
    pub(super) begin: f32,
    /// From there to the last.
    pub(super) width: f32,
}

/// What rows are found in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Rear and front of each row: above and below everything where there is nothing.
    rows: Vec<[f64; 2]>,
}

const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl Task<'_> {
    /// How far ahead a point is, and how far aside.
    fn place(&self, point: u32) -> [f64; 2] {
        let [x, y, ..] = self.motion[point as usize].map(f64::from);
        let [dx, dy] = self.ahead.map(f64::from);
        [dx * x + dy * y, dy * x - dx * y]
    }

    /// Whether a point is of the cluster whose label this is, and comes after another, so that each edge is looked at once.
    fn is_end(&self, label: u32, point: u32, other: u32) -> bool {
        other > point && self.labels[other as usize] == label
    }
}

impl Scratch {
    /// Appends rear and front of each row of a cluster, rows at most `row` pixels apart. There is room for two a point, and
    /// for what is left in `room`, from which rows beyond are taken.
    pub(super) fn find(&mut self, task: Task, row: f64, room: &mut usize, found: &mut Vec<[f32; 2]>) -> Across {
        let asides = task.members.iter().map(|(_, point)| task.place(*point)[1]);
        let [least, most] = asides.fold(NOTHING, |[least, most], aside| [least.min(aside), most.max(aside)]);
        let begin = least as f32;
        let across = Across { begin, width: ((most - f64::from(begin)) as f32).max(0.0) };
        let width = f64::from(across.width);
        let own = 2 * task.members.len();
        let wanted = if across.width < LEAST_EXTENT { 1 } else { (width / row).ceil() as usize + 1 };
        let count = wanted.min(own + *room);
        *room -= count.saturating_sub(own);
        self.rows.clear();
        self.rows.resize(count, NOTHING);
        let per_pixel = if count > 1 { (count - 1) as f64 / width } else { 0.0 };
        for (label, point) in task.members {
            let place = |point| {
                let [ahead, aside] = task.place(point);
                [ahead, (aside - f64::from(begin)) * per_pixel]
            };
            let from = place(*point);
            self.add(from, from);
            let others = task.mesh.neighbours().of(*point as usize).iter();
            others.filter(|other| task.is_end(*label, *point, **other)).for_each(|other| self.add(from, place(*other)));
        }
        self.fill();
        found.extend((0..count).map(|row| self.mean_around(row).map(|c| c as f32)));
        across
    }

    /// Widens the rows that an edge passes. Its ends are so far ahead, and so many rows aside.
    fn add(&mut self, from: [f64; 2], to: [f64; 2]) {
        let [from, to] = if from[1] <= to[1] { [from, to] } else { [to, from] };
        let last = self.rows.len() as f64 - 1.0;
        let [first, end] = [(from[1] - 0.5).ceil(), (to[1] + 0.5).floor()].map(|row| row.clamp(0.0, last) as usize);
        let length = to[1] - from[1];
        for row in first..=end {
            for border in [row as f64 - 0.5, row as f64 + 0.5] {
                let share = if length > 0.0 { ((border - from[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
                let ahead = from[0] + share * (to[0] - from[0]);
                let [rear, front] = &mut self.rows[row];
                (*rear, *front) = (rear.min(ahead), front.max(ahead));
            }
        }
    }

    /// Rows with nothing get what lies between those beside them; the first and the last have a point.
    fn fill(&mut self) {
        let mut before = 0;
        for row in 1..self.rows.len() {
            if self.rows[row] == NOTHING {
                continue;
            }
            let (from, to) = (self.rows[before], self.rows[row]);
            for between in before + 1..row {
                let share = (between - before) as f64 / (row - before) as f64;
                self.rows[between] = [0, 1].map(|side| from[side] + share * (to[side] - from[side]));
            }
            before = row;
        }
    }

    fn mean_around(&self, row: usize) -> [f64; 2] {
        let far = (SMOOTHED as usize).min(row).min(self.rows.len() - 1 - row);
        let around = &self.rows[row - far..=row + far];
        [0, 1].map(|side| around.iter().map(|bounds| bounds[side]).sum::<f64>() / around.len() as f64)
    }
}
