//! The data from which the device makes trajectories of the poses that it holds.

use super::breaks::{Corners, corners};
use super::spline::Spline;
use super::window::{FrameView, Knot, MOST_POSES, Pose, Segment, Window};
use super::{Motion, Scratch};
use crate::blur::limits::MOST_KNOTS;
use crate::shaders::blur::constants::PIECE_SEGMENTS;

/// What was found last.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    knots: Vec<Knot>,
    segments: Vec<Segment>,
    spline: Spline,
}

impl Motion {
    /// The frames that the trajectories of [`Motion::interval`] go through, and the weights that solve their splines, for
    /// [`crate::blur::Trajectories::Poses`]. None where the device can't make the trajectories, or nothing moves: with
    /// poses between frames, or more of them than it takes. The window is the one that the interval was found in. Memory is
    /// kept as in [`Motion::renew`].
    pub fn knots(&mut self, window: &Window) -> Option<&[Knot]> {
        let window = &self.nearby(window);
        let is_found = self.with_scratch(|motion, scratch| {
            motion.find_cuts(&mut scratch.cuts, window);
            motion.find_knots(scratch, window, Some(&corners(&window.poses[window.current])))
        });
        is_found.then_some(&self.scratch.knots.knots)
    }

    /// The same where only the device knows the poses, which all count as different: frames that follow each other, of which
    /// `current` is the place of frame i; and the segments of the trajectories. No cut is found: frames of one shot only.
    pub fn knots_of_views(&mut self, views: &[FrameView], current: usize) -> Option<(&[Knot], &[Segment])> {
        let frame = views.get(current)?.frame;
        let places = self.nearby_places(current, views.len());
        let (views, current) = (&views[places.clone()], current - places.start);
        // Positions that differ are all that is looked at.
        let marks: [_; MOST_POSES] = std::array::from_fn(|place| [[place as f32, 0.0, 0.0]]);
        let pose = |place: usize| {
            let view = &views[place.min(views.len() - 1)].view;
            Pose { positions: &marks[place], view, cut: false }
        };
        let poses: [Pose; MOST_POSES] = std::array::from_fn(pose);
        let window = Window { frame, poses: &poses[..views.len()], current, between: &[] };
        let is_found = self.with_scratch(|motion, scratch| {
            scratch.cuts.clear();
            motion.find_knots(scratch, &window, None)
        });
        is_found.then_some((&self.scratch.knots.knots, &self.scratch.knots.segments))
    }

    /// Finds the knots of a window whose cuts are found; false if there are none.
    fn find_knots(&self, scratch: &mut Scratch, window: &Window, corners: Option<&Corners>) -> bool {
        let Scratch { cuts, timeline, knots: Found { knots, segments, spline }, .. } = scratch;
        if !window.between.is_empty() || !self.find_timeline(timeline, window, cuts, corners) {
            return false;
        }
        if timeline.knots.len() > MOST_KNOTS || timeline.spans.len() > PIECE_SEGMENTS as usize {
            return false;
        }
        let first = i64::from(window.frame) - window.current as i64;
        knots.clear();
        for knot in &timeline.knots {
            let Ok(frame) = u32::try_from(first + knot.pose as i64) else { return false };
            let view = FrameView { frame, view: *window.pose(knot.sight).view };
            knots.push(Knot { view, weights: [[0.0; 4]; PIECE_SEGMENTS as usize] });
        }
        spline.renew(timeline.times(), self.settings.trajectory);
        for (place, span) in timeline.spans.iter().enumerate() {
            let ([a, b], squared) = (span.knots, timeline.squared(span.knots));
            knots[b].weights[place][1] += 1.0;
            knots[a].weights[place][1] -= 1.0;
            // Frame i's own place is given as it is.
            knots[a].weights[place][0] = if place == 0 { 0.0 } else { 1.0 };
            for (row, knot) in [(2, a), (3, b)] {
                let weights = knots.iter_mut().map(|knot| &mut knot.weights[place][row]);
                weights.zip(spline.weights(knot)).for_each(|(all, weight)| *all = (squared * weight) as f32);
            }
        }
        segments.clear();
        segments.extend(timeline.spans.iter().map(|span| span.segment));
        true
    }
}
