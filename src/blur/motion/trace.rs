//! Position, velocity and trajectory of every point over one interval.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

use super::projection::PixelClip;
use super::spline::{Spline, offset};
use super::timeline::{Knot, Span, Timeline};
use super::window::{Segment, Window};
use crate::blur::settings::{Space, Trajectory};
use crate::shaders::blur::blocks::Piece;
use crate::shaders::blur::constants::STATIC;
use crate::threads::together;

/// Points that are worked on together: what belongs to them stays in the cache.
const TRACED: usize = 512;
/// The largest number that the device is given.
const MOST: f64 = f32::MAX as f64;

/// What is known of each point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traces<'a> {
    /// As in [`super::Interval::motion`].
    pub(super) motion: &'a [[f32; 4]],
    /// Picture displacement from frame i to frame i + 1 in pixels; NaN for a point that is static or is not in front of
    /// the camera.
    pub(super) moves: &'a [[f32; 2]],
}

/// The input and options of a trace.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task<'a> {
    pub(super) window: &'a Window<'a>,
    pub(super) timeline: &'a Timeline,
    pub(super) space: Space,
    pub(super) trajectory: Trajectory,
    /// In frames after frame i.
    pub(super) reference_time: f64,
    /// Frames before frame i that trajectories are looked at.
    pub(super) reach: f64,
    /// Frames after frame i + 1.
    pub(super) lead: f64,
}

/// Buffers that are used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    plan: Plan,
    moves: Vec<[f32; 2]>,
    /// One for each thread.
    samples: Vec<Samples>,
}

/// What is the same for all points.
#[derive(Clone, Debug, Default)]
struct Plan {
    spline: Spline,
    /// Knots that a span ends at, ascending. Places of knots are those in here.
    used: Vec<usize>,
    /// The weights of all knots in the second derivative at each of these.
    weights: Vec<f64>,
    /// Which of the weights are a knot's: none where its second derivative is 0.
    bends: Vec<Range<usize>>,
    spans: Vec<SpanEnds>,
    /// Places of the knots of frames i and i + 1.
    ends: [usize; 2],
    /// The span of the reference time.
    reference: Option<usize>,
    /// The span that begins first.
    earliest: usize,
    /// The span that ends last.
    latest: usize,
    /// Knots in which a point must be in front of the camera.
    seen: Vec<usize>,
    /// Whether all knots have one projection: then positions are summed before they are projected.
    still_camera: bool,
}

/// What is the same for all points of one span.
#[derive(Clone, Copy, Debug)]
struct SpanEnds {
    /// Places of its knots.
    places: [usize; 2],
    /// Square of its length.
    squared: f64,
}

/// What splines are made of at the points of a block, place by place.
#[derive(Clone, Debug, Default)]
struct Samples {
    points: usize,
    /// The interpolated channels.
    channels: Vec<DVec3>,
    /// Their second derivatives by time, three numbers a point.
    bends: Vec<f64>,
    /// What is summed to these, of one knot.
    summed: Vec<f64>,
    /// Whether each point is in front of the camera wherever it is looked at.
    seen: Vec<bool>,
}

/// The outputs of one block.
struct Block<'a> {
    first: usize,
    motion: &'a mut [[f32; 4]],
    moves: &'a mut [[f32; 2]],
}

impl Block<'_> {
    fn points(&self) -> Range<usize> {
        self.first..self.first + self.motion.len()
    }
}

impl Scratch {
    /// [`Traces::moves`] of what was traced last.
    pub(super) fn moves(&self) -> &[[f32; 2]] {
        &self.moves
    }

    /// Traces all points on `threads` threads, to an interval's motion and pieces. False if a position that is used is not
    /// finite.
    pub(super) fn find(
        &mut self,
        task: Task,
        threads: usize,
        motion: &mut Vec<[f32; 4]>,
        pieces: &mut Vec<Piece>,
    ) -> bool {
        self.plan.renew(&task);
        let points = task.window.poses[task.window.current].positions.len();
        // Every one of them is written.
        motion.resize(points, [0.0; 4]);
        self.moves.resize(points, [0.0; 2]);
        pieces.resize(points * task.timeline.spans.len(), Piece::zeroed());
        let samples = self.samples.len().max(threads).max(1);
        self.samples.resize_with(samples, Samples::default);
        let tracer = Tracer { task, plan: &self.plan };
        let outputs = motion.chunks_mut(TRACED).zip(self.moves.chunks_mut(TRACED));
        let blocks = outputs.enumerate().map(|(n, (motion, moves))| Block { first: n * TRACED, motion, moves });
        match &mut self.samples[..threads.max(1)] {
            [samples] => { blocks }.all(|block| {
                let own = block.points();
                tracer.trace(samples, block, pieces.chunks_exact_mut(points).map(|slab| &mut slab[own.clone()]))
            }),
            // What starts threads, and what they share, allocates.
            samples => {
                let mut slabs: Vec<_> = pieces.chunks_exact_mut(points).map(|slab| slab.chunks_mut(TRACED)).collect();
                let own = |block| (block, slabs.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>());
                tracer.share(samples, blocks.map(own))
            }
        }
    }

    /// Traces points that all stay at `positions`. False if one is not finite.
    pub(super) fn still(
        &mut self,
        positions: &[[f32; 3]],
        projection: &PixelClip,
        space: Space,
        motion: &mut Vec<[f32; 4]>,
        pieces: &mut Vec<Piece>,
    ) -> bool {
        self.moves.clear();
        self.moves.resize(positions.len(), [f32::NAN; 2]);
        motion.clear();
        pieces.clear();
        for position in positions {
            let clip = projection.clip(*position);
            if !clip.is_finite() {
                return false;
            }
            let pixel = projection.pixel_of(clip);
            let channels = if space == Space::Screen { pixel.extend(clip.z) } else { clip };
            let visible = clip.z > projection.near && pixel.as_vec2().is_finite();
            let [x, y] = if visible { pixel.as_vec2().to_array() } else { [0.0; 2] };
            motion.push([x, y, 0.0, 0.0]);
            let curve = Curve { begin: channels, ..Curve::default() };
            pieces.push(curve.piece(DVec3::ZERO, false));
        }
        true
    }
}

impl Plan {
    fn renew(&mut self, task: &Task) {
        let Timeline { knots, spans, ends, .. } = task.timeline;
        self.used.clear();
        self.used.extend(spans.iter().flat_map(|span| span.knots));
        self.used.sort_unstable();
        self.used.dedup();
        let place = |knot: usize| self.used.partition_point(|other| *other < knot);
        self.ends = ends.map(place);
        self.spans.clear();
        let ends_of = |knots: [usize; 2]| SpanEnds { places: knots.map(place), squared: task.timeline.squared(knots) };
        self.spans.extend(spans.iter().map(|span| ends_of(span.knots)));
        let within = |span: &Span| {
            let Segment { begin, end } = span.segment;
            f64::from(begin) <= task.reference_time && task.reference_time <= f64::from(end)
        };
        self.reference = spans.iter().position(within);
        let begin = |span: &usize| spans[*span].segment.begin;
        self.earliest = (0..spans.len()).min_by(|a, b| begin(a).total_cmp(&begin(b))).unwrap_or(0);
        self.latest = (0..spans.len()).max_by(|a, b| begin(a).total_cmp(&begin(b))).unwrap_or(0);
        self.still_camera = knots.iter().all(|knot| knot.projection == knots[0].projection);
        self.weigh(task);
        self.look(task);
    }

    /// Finds the weights.
    fn weigh(&mut self, task: &Task) {
        self.spline.renew(task.timeline.times(), task.trajectory);
        self.weights.clear();
        self.bends.clear();
        for knot in &self.used {
            let begin = self.weights.len();
            self.weights.extend_from_slice(self.spline.weights(*knot));
            self.bends.push(begin..self.weights.len());
        }
    }

    /// Finds the knots in which points must be seen.
    fn look(&mut self, task: &Task) {
        let (last, [a, b]) = (task.timeline.knots.len() - 1, task.timeline.ends);
        self.seen.clear();
        self.seen.extend(match task.space {
            Space::Screen => 0..=last,
            Space::Homogeneous => a.saturating_sub(1)..=(b + 1).min(last),
        });
        self.seen.extend(&self.used);
        self.seen.sort_unstable();
        self.seen.dedup();
    }
}

impl Samples {
    /// A piece of the trajectory of one point.
    fn curve(&self, SpanEnds { places, squared }: &SpanEnds, point: usize) -> Curve {
        let [begin, end] = places.map(|place| self.channels[place * self.points + point]);
        let bend = |place: usize| DVec3::from_slice(&self.bends[3 * (place * self.points + point)..][..3]);
        Curve { begin, step: end - begin, bends: places.map(|place| bend(place) * *squared) }
    }
}

/// Traces blocks of points.
#[derive(Clone, Copy)]
struct Tracer<'a> {
    task: Task<'a>,
    plan: &'a Plan,
}

impl<'a> Tracer<'a> {
    /// Traces blocks, with the slices of their pieces, on as many threads as there are samples. False if a position is not
    /// finite.
    fn share<'p>(
        &self,
        samples: &mut [Samples],
        blocks: impl Iterator<Item = (Block<'p>, Vec<&'p mut [Piece]>)> + Send,
    ) -> bool {
        let others = samples.len() - 1;
        let (samples, blocks) = (Mutex::new(samples.iter_mut()), Mutex::new(blocks));
        let next = || blocks.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = || {
            let samples = samples.lock().unwrap_or_else(PoisonError::into_inner).next();
            samples.is_none_or(|samples| {
                std::iter::from_fn(next).all(|(block, pieces)| self.trace(samples, block, pieces))
            })
        };
        together(others, work).into_iter().all(|good| good)
    }

    fn positions(&self, knot: &Knot) -> &'a [[f32; 3]] {
        self.task.window.pose(knot.pose).positions
    }

    /// The interpolated channels: clip coordinates, or pixels and depth.
    fn channels(&self, projection: &PixelClip, position: [f32; 3]) -> DVec3 {
        let clip = projection.clip(position);
        match self.task.space {
            Space::Homogeneous => clip,
            Space::Screen => projection.pixel_of(clip).extend(clip.z),
        }
    }

    /// Traces the points of a block, with a slice of pieces for each span; false if a position is not finite.
    fn trace<'p>(
        &self,
        samples: &mut Samples,
        block: Block,
        pieces: impl IntoIterator<Item = &'p mut [Piece]>,
    ) -> bool {
        let points = block.points();
        self.sample(samples, points.clone());
        self.bend(samples, points.clone());
        self.look(samples, points.clone());
        let good = self.is_finite(samples, points);
        for (point, (motion, moves)) in block.motion.iter_mut().zip(block.moves).enumerate() {
            (*motion, *moves) = ([0.0; 4], [f32::NAN; 2]);
            samples.seen[point] &= self.stays_seen(samples, point);
            if samples.seen[point] {
                *motion = self.motion(samples, point);
                *moves = self.moves(samples, point, *motion);
            }
        }
        let begin = self.plan.ends[0] * samples.points;
        for (s, (span, pieces)) in self.plan.spans.iter().zip(pieces).enumerate() {
            for (point, piece) in pieces.iter_mut().enumerate() {
                let origin = if s == 0 { DVec3::ZERO } else { samples.channels[begin + point] };
                *piece = samples.curve(span, point).piece(origin, samples.seen[point]);
            }
        }
        good
    }

    /// Finds the channels at the knots that spans end at.
    fn sample(&self, samples: &mut Samples, points: Range<usize>) {
        samples.points = points.len();
        samples.channels.clear();
        for knot in self.plan.used.iter().map(|knot| &self.task.timeline.knots[*knot]) {
            let positions = &self.positions(knot)[points.clone()];
            samples.channels.extend(positions.iter().map(|position| self.channels(&knot.projection, *position)));
        }
    }

    /// Finds second derivatives at these knots.
    fn bend(&self, samples: &mut Samples, points: Range<usize>) {
        let Samples { bends, summed, .. } = samples;
        let (count, plan) = (3 * points.len(), self.plan);
        bends.clear();
        bends.resize(count * plan.used.len(), 0.0);
        if plan.weights.is_empty() {
            return;
        }
        let projected_last = plan.still_camera && self.task.space == Space::Homogeneous;
        summed.resize(count, 0.0);
        for (place, knot) in self.task.timeline.knots.iter().enumerate() {
            let positions = &self.positions(knot)[points.clone()];
            if projected_last {
                summed.iter_mut().zip(positions.as_flattened()).for_each(|(value, x)| *value = f64::from(*x));
            } else {
                for (value, position) in summed.chunks_exact_mut(3).zip(positions) {
                    self.channels(&knot.projection, *position).write_to_slice(value);
                }
            }
            for (sums, weights) in bends.chunks_exact_mut(count).zip(&plan.bends) {
                if let Some(weight) = plan.weights[weights.clone()].get(place) {
                    sums.iter_mut().zip(&*summed).for_each(|(sum, value)| *sum += weight * value);
                }
            }
        }
        if projected_last {
            let linear = self.task.timeline.knots[0].projection.linear;
            bends.chunks_exact_mut(3).for_each(|sum| (linear * DVec3::from_slice(sum)).write_to_slice(sum));
        }
    }

    /// Finds which points are in front of the camera at the knots.
    fn look(&self, samples: &mut Samples, points: Range<usize>) {
        samples.seen.clear();
        samples.seen.resize(points.len(), true);
        for knot in self.plan.seen.iter().map(|knot| &self.task.timeline.knots[*knot]) {
            let PixelClip { linear, offset, near, .. } = knot.projection;
            let (row, positions) = (linear.row(2), &self.positions(knot)[points.clone()]);
            for (seen, position) in samples.seen.iter_mut().zip(positions) {
                *seen &= row.dot(DVec3::from_array(position.map(f64::from))) + offset.z > near;
            }
        }
    }

    /// Whether all positions are. What is not finite stays so when it is summed; in screen space what is beside the camera
    /// is infinite too.
    fn is_finite(&self, samples: &Samples, points: Range<usize>) -> bool {
        let finite = |positions: &[[f32; 3]]| positions.as_flattened().iter().all(|c| c.is_finite());
        let are_finite = |span: &SpanEnds| (0..points.len()).all(|point| samples.curve(span, point).is_finite());
        match self.task.space {
            Space::Homogeneous => self.plan.spans.iter().all(are_finite),
            Space::Screen => self.task.timeline.knots.iter().all(|knot| finite(&self.positions(knot)[points.clone()])),
        }
    }

    /// Whether depth stays above 0 between the knots too, and where trajectories are extended.
    fn stays_seen(&self, samples: &Samples, point: usize) -> bool {
        let mut curves = self.plan.spans.iter().map(|span| samples.curve(span, point));
        let Segment { begin, end } = self.task.timeline.spans[self.plan.earliest].segment;
        let beyond = self.task.reach + f64::from(begin);
        let reached = beyond <= 0.0 || {
            let curve = samples.curve(&self.plan.spans[self.plan.earliest], point);
            let slope = curve.at(0.0)[1].z / f64::from(end - begin);
            curve.begin.z - slope * beyond > 0.0
        };
        let leads = || {
            let latest = self.plan.latest;
            let Segment { begin, end } = self.task.timeline.spans[latest].segment;
            let curve = samples.curve(&self.plan.spans[latest], point);
            curve.begin.z + curve.step.z + curve.at(1.0)[1].z / f64::from(end - begin) * self.task.lead > 0.0
        };
        reached && (self.task.lead == 0.0 || leads()) && curves.all(|curve| curve.lowest_depth() > 0.0)
    }

    /// Position and velocity at the reference time; zeros where they are not numbers.
    fn motion(&self, samples: &Samples, point: usize) -> [f32; 4] {
        let Some(span) = self.plan.reference else { return [0.0; 4] };
        let Segment { begin, end } = self.task.timeline.spans[span].segment;
        let length = f64::from(end) - f64::from(begin);
        let curve = samples.curve(&self.plan.spans[span], point);
        let [y, slope] = curve.at((self.task.reference_time - f64::from(begin)) / length);
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
    fn moves(&self, samples: &Samples, point: usize, motion: [f32; 4]) -> [f32; 2] {
        let [a, b] = self.plan.ends.map(|place| self.pixel(samples.channels[place * samples.points + point]));
        let moves = (b - a).to_array().map(|c| c as f32);
        let moved = (b - a).length() >= f64::from(STATIC) && moves.iter().all(|c| c.is_finite()) && motion != [0.0; 4];
        if moved { moves } else { [f32::NAN; 2] }
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
