//! Position, velocity and trajectory of every point over one interval.

use std::sync::{Mutex, PoisonError};

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

use super::projection::PixelClip;
use super::spline::{Knot, Spline, Timeline, offset};
use super::window::Segment;
use crate::blur::settings::{Space, Trajectory};
use crate::shaders::blur::blocks::Piece;
use crate::shaders::blur::constants::STATIC;
use crate::threads::together;

/// Points that are worked on together: what belongs to them stays in the cache.
const TRACED: usize = 512;
/// The largest number that the device is given.
const MOST: f64 = f32::MAX as f64;

/// Results of the points' traces.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Traces {
    /// As in [`super::Interval::motion`].
    pub(super) motion: Vec<[f32; 4]>,
    /// Picture displacement from frame i to frame i + 1 in pixels; NaN for a point that is static or is not in front of
    /// the camera.
    pub(super) moves: Vec<[f32; 2]>,
    /// As in [`super::Interval::pieces`].
    pub(super) pieces: Vec<Piece>,
}

/// The input and options of a trace.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task<'a> {
    pub(super) timeline: &'a Timeline<'a>,
    pub(super) space: Space,
    pub(super) trajectory: Trajectory,
    /// In frames after frame i.
    pub(super) reference_time: f64,
    /// Frames before frame i that trajectories are looked at.
    pub(super) reach: f64,
}

/// The outputs of one block.
struct Block<'a> {
    first: usize,
    motion: &'a mut [[f32; 4]],
    moves: &'a mut [[f32; 2]],
    /// A slice for each span.
    pieces: Vec<&'a mut [Piece]>,
}

/// Data that all blocks share.
struct Shared<'a> {
    task: Task<'a>,
    knots: &'a [Knot<'a>],
    /// Weights of all knots in the second derivative at each knot that a span ends at.
    bends: Vec<Vec<f64>>,
    ends: Vec<SpanEnds>,
    /// Knots in which a point must be in front of the camera.
    seen: Vec<usize>,
    /// Whether all knots have one projection: then positions are summed before they are projected.
    still_camera: bool,
}

/// Data of one span.
struct SpanEnds {
    knots: [usize; 2],
    /// Places of the knots in [`Shared::bends`].
    bends: [usize; 2],
    /// Square of the span's length.
    squared: f64,
}

impl Traces {
    /// Traces all points on `threads` threads. `None` if a position that is used is not finite.
    pub(super) fn new(task: Task, threads: usize) -> Option<Traces> {
        let knots = &task.timeline.knots;
        let (points, spans) = (knots[0].positions.len(), task.timeline.spans.len());
        let mut traces = Traces {
            motion: vec![[0.0; 4]; points],
            moves: vec![[f32::NAN; 2]; points],
            pieces: vec![Piece::zeroed(); points * spans],
        };
        let shared = Shared::new(task);
        let mut slabs: Vec<_> = traces.pieces.chunks_mut(points).map(|slab| slab.chunks_mut(TRACED)).collect();
        let outputs = traces.motion.chunks_mut(TRACED).zip(traces.moves.chunks_mut(TRACED));
        let blocks = outputs.enumerate().map(|(n, (motion, moves))| Block {
            first: n * TRACED,
            motion,
            moves,
            pieces: slabs.iter_mut().filter_map(Iterator::next).collect(),
        });
        let mut blocks: Vec<Block> = blocks.collect();
        let share = blocks.len().div_ceil(threads.max(1));
        let work = |blocks: &mut [Block]| blocks.iter_mut().all(|block| shared.trace(block));
        let parts = Mutex::new(blocks.chunks_mut(share));
        let next = || parts.lock().unwrap_or_else(PoisonError::into_inner).next();
        let good = together(threads.max(1) - 1, || std::iter::from_fn(next).all(work));
        good.into_iter().all(|good| good).then_some(traces)
    }
}

impl<'a> Shared<'a> {
    fn new(task: Task<'a>) -> Shared<'a> {
        let knots = &task.timeline.knots;
        let times: Vec<f64> = knots.iter().map(|knot| knot.time).collect();
        let spline = Spline::new(&times, task.trajectory);
        let mut used: Vec<usize> = task.timeline.spans.iter().flat_map(|span| span.knots).collect();
        used.sort_unstable();
        used.dedup();
        let place = |knot: usize| used.partition_point(|other| *other < knot);
        let ends = task.timeline.spans.iter().map(|span| SpanEnds {
            knots: span.knots,
            bends: span.knots.map(place),
            squared: (times[span.knots[1]] - times[span.knots[0]]).powi(2),
        });
        let ends: Vec<SpanEnds> = ends.collect();
        let [a, b] = task.timeline.ends;
        let mut seen: Vec<usize> = match task.space {
            Space::Screen => (0..knots.len()).collect(),
            Space::Homogeneous => (a.saturating_sub(1)..=(b + 1).min(knots.len() - 1)).collect(),
        };
        seen.extend(&used);
        seen.sort_unstable();
        seen.dedup();
        Shared {
            task,
            knots,
            bends: used.iter().map(|knot| spline.weights(*knot)).collect(),
            ends,
            seen,
            still_camera: knots.iter().all(|knot| knot.projection == knots[0].projection),
        }
    }

    /// The interpolated channels: clip coordinates, or pixels and depth.
    fn channels(&self, knot: usize, point: usize) -> DVec3 {
        let projection = &self.knots[knot].projection;
        let clip = projection.clip(self.knots[knot].positions[point]);
        match self.task.space {
            Space::Homogeneous => clip,
            Space::Screen => projection.pixel_of(clip).extend(clip.z),
        }
    }

    /// Traces the points of a block; false if a position is not finite.
    fn trace(&self, block: &mut Block) -> bool {
        let count = block.motion.len();
        let bends = self.second_derivatives(block.first, count);
        let mut good = true;
        let mut curves = vec![Curve::default(); self.ends.len()];
        for j in 0..count {
            let point = block.first + j;
            let origin = self.channels(self.task.timeline.ends[0], point);
            for (curve, span) in curves.iter_mut().zip(&self.ends) {
                let [a, b] = span.knots.map(|knot| self.channels(knot, point));
                let bends = span.bends.map(|place| bends[place][j] * span.squared);
                *curve = Curve { begin: a, step: b - a, bends };
            }
            good &= self.is_finite(point, &curves);
            let seen = self.is_seen(point, &curves);
            if seen {
                block.motion[j] = self.motion(&curves);
                block.moves[j] = self.moves(point, block.motion[j]);
            }
            for (s, (curve, pieces)) in curves.iter().zip(&mut block.pieces).enumerate() {
                let origin = if s == 0 { DVec3::ZERO } else { origin };
                pieces[j] = curve.piece(origin, seen);
            }
        }
        good
    }

    /// Whether all positions of a point are. What is not finite stays so when it is summed; in screen space what is
    /// beside the camera is infinite too.
    fn is_finite(&self, point: usize, curves: &[Curve]) -> bool {
        match self.task.space {
            Space::Homogeneous => curves.iter().all(Curve::is_finite),
            Space::Screen => self.knots.iter().all(|knot| knot.positions[point].iter().all(|c| c.is_finite())),
        }
    }

    /// Whether a point is in front of the camera wherever it is looked at.
    fn is_seen(&self, point: usize, curves: &[Curve]) -> bool {
        let depth = |projection: &PixelClip, p: [f32; 3]| {
            projection.linear.row(2).dot(DVec3::from_array(p.map(f64::from))) + projection.offset.z
        };
        let before = |knot: &Knot| depth(&knot.projection, knot.positions[point]) > knot.projection.near;
        self.seen.iter().all(|knot| before(&self.knots[*knot])) && self.stays_seen(curves)
    }

    /// Whether depth stays above 0 between the knots too, and where trajectories are extended.
    fn stays_seen(&self, curves: &[Curve]) -> bool {
        let spans = &self.task.timeline.spans;
        let earliest = spans.iter().zip(curves).min_by(|a, b| a.0.segment.begin.total_cmp(&b.0.segment.begin));
        let reached = earliest.is_none_or(|(span, curve)| {
            let beyond = self.task.reach + f64::from(span.segment.begin);
            let slope = curve.at(0.0)[1].z / f64::from(span.segment.end - span.segment.begin);
            beyond <= 0.0 || curve.begin.z - slope * beyond > 0.0
        });
        reached && curves.iter().all(|curve| curve.lowest_depth() > 0.0)
    }

    /// Position and velocity at the reference time; zeros where they are not numbers.
    fn motion(&self, curves: &[Curve]) -> [f32; 4] {
        let time = self.task.reference_time;
        let spans = &self.task.timeline.spans;
        let within = |j: &usize| {
            let segment = spans[*j].segment;
            f64::from(segment.begin) <= time && time <= f64::from(segment.end)
        };
        let Some(j) = (0..spans.len()).find(within) else { return [0.0; 4] };
        let Segment { begin, end } = spans[j].segment;
        let length = f64::from(end) - f64::from(begin);
        let [y, slope] = curves[j].at((time - f64::from(begin)) / length);
        let (pixel, slope) = (self.pixel(y), slope / length);
        let velocity = match self.task.space {
            Space::Homogeneous => (slope.truncate() - pixel * slope.z) / y.z,
            Space::Screen => slope.truncate(),
        };
        let motion = [pixel.x, pixel.y, velocity.x, velocity.y].map(|c| c as f32 + 0.0);
        if motion.iter().all(|c| c.is_finite()) { motion } else { [0.0; 4] }
    }

    fn pixel(&self, channels: DVec3) -> DVec2 {
        match self.task.space {
            Space::Homogeneous => channels.truncate() / channels.z,
            Space::Screen => channels.truncate(),
        }
    }

    /// How far a point's picture moves, if it is not static and the numbers that describe it are finite.
    fn moves(&self, point: usize, motion: [f32; 4]) -> [f32; 2] {
        let [a, b] = self.task.timeline.ends.map(|knot| self.pixel(self.channels(knot, point)));
        let moves = (b - a).to_array().map(|c| c as f32);
        let moved = (b - a).length() >= f64::from(STATIC) && moves.iter().all(|c| c.is_finite()) && motion != [0.0; 4];
        if moved { moves } else { [f32::NAN; 2] }
    }

    /// Second derivatives by time at each of `bends`' knots, for `count` points from `first`.
    fn second_derivatives(&self, first: usize, count: usize) -> Vec<Vec<DVec3>> {
        if self.bends.iter().all(Vec::is_empty) {
            return self.bends.iter().map(|_| vec![DVec3::ZERO; count]).collect();
        }
        let mut sums = vec![vec![0.0; 3 * count]; self.bends.len()];
        let mut values = vec![0.0; 3 * count];
        for (knot, at) in self.knots.iter().enumerate() {
            let positions = &at.positions[first..first + count];
            if self.still_camera && self.task.space == Space::Homogeneous {
                let flat: &[f32] = bytemuck::cast_slice(positions);
                values.iter_mut().zip(flat).for_each(|(value, position)| *value = f64::from(*position));
            } else {
                for (j, value) in values.chunks_exact_mut(3).enumerate() {
                    value.copy_from_slice(&self.channels(knot, first + j).to_array());
                }
            }
            for (sum, weights) in sums.iter_mut().zip(&self.bends) {
                if let Some(weight) = weights.get(knot) {
                    sum.iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight * value);
                }
            }
        }
        let projected = self.still_camera && self.task.space == Space::Homogeneous;
        let linear = self.knots[0].projection.linear;
        let project = |sum: &[f64]| match projected {
            true => linear * DVec3::from_slice(sum),
            false => DVec3::from_slice(sum),
        };
        sums.iter().map(|sum| sum.chunks_exact(3).map(project).collect()).collect()
    }
}

/// A piece of one point's trajectory.
#[derive(Clone, Copy, Debug, Default)]
struct Curve {
    begin: DVec3,
    step: DVec3,
    bends: [DVec3; 2],
}

impl Curve {
    fn is_finite(&self) -> bool {
        self.begin.is_finite() && self.step.is_finite() && self.bends[0].is_finite() && self.bends[1].is_finite()
    }

    /// Value, and derivative by u.
    fn at(&self, u: f64) -> [DVec3; 2] {
        let parts: [[f64; 2]; 3] = std::array::from_fn(|c| offset(self.step[c], self.bends.map(|b| b[c]), u));
        [self.begin + DVec3::from_array(parts.map(|p| p[0])), DVec3::from_array(parts.map(|p| p[1]))]
    }

    /// A bound of depth from below: the cubic stays within its Bezier points.
    fn lowest_depth(&self) -> f64 {
        let (a, b) = (self.begin.z, self.begin.z + self.step.z);
        let slope = |u: f64| offset(self.step.z, self.bends.map(|bend| bend.z), u)[1] / 3.0;
        a.min(b).min(a + slope(0.0)).min(b - slope(1.0))
    }

    /// As the device takes it, rounded once; straight if it is not `curved`.
    fn piece(&self, origin: DVec3, curved: bool) -> Piece {
        let row = |v: DVec3| {
            let [x, y, z] = v.to_array().map(|c| if c.is_nan() { 0.0 } else { c.clamp(-MOST, MOST) as f32 });
            [x, y, z, 0.0]
        };
        let [bend_begin, bend_end] = if curved { self.bends } else { [DVec3::ZERO; 2] }.map(row);
        Piece { origin: row(self.begin - origin), step: row(self.step), bend_begin, bend_end }
    }
}

impl Traces {
    /// Points that all are where `knot` has them. `None` if a position is not finite.
    pub(super) fn still(knot: &Knot, space: Space) -> Option<Traces> {
        let mut traces = Traces::default();
        for position in knot.positions {
            let clip = knot.projection.clip(*position);
            if !clip.is_finite() {
                return None;
            }
            let pixel = knot.projection.pixel_of(clip);
            let channels = if space == Space::Screen { pixel.extend(clip.z) } else { clip };
            let visible = clip.z > knot.projection.near && pixel.as_vec2().is_finite();
            let [x, y] = if visible { pixel.as_vec2().to_array() } else { [0.0; 2] };
            traces.motion.push([x, y, 0.0, 0.0]);
            let curve = Curve { begin: channels, ..Curve::default() };
            traces.pieces.push(curve.piece(DVec3::ZERO, false));
        }
        traces.moves = vec![[f32::NAN; 2]; knot.positions.len()];
        Some(traces)
    }
}
