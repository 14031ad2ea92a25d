//! The data from which the device makes trajectories of the poses that it holds.

use super::spline::{Spline, timeline};
use super::window::{FrameView, Knot, Pose, Segment, Window};
use super::{Motion, cuts};
use crate::blur::limits::MOST_KNOTS;
use crate::shaders::blur::constants::PIECE_SEGMENTS;

impl Motion {
    /// The frames that the trajectories of [`Motion::interval`] go through, and the weights that solve their splines, for
    /// [`crate::blur::Trajectories::Poses`]. None where the device can't make the trajectories, or nothing moves: with
    /// poses between frames, or more of them than it takes. The window is the one that the interval was found in.
    pub fn knots(&self, window: &Window) -> Option<Vec<Knot>> {
        let window = &self.nearby(window);
        let project = |pose: &Pose| self.project(window, pose);
        let cuts = cuts(window.poses, f64::from(self.settings.jump) * f64::from(self.size[1]), project);
        self.knots_between(window, &cuts).map(|(knots, _)| knots)
    }

    /// The same where only the device knows the poses, which all count as different: frames that follow each other, of which
    /// `current` is the place of frame i; and the segments of the trajectories. No cut is found: frames of one shot only.
    pub fn knots_of_views(&self, views: &[FrameView], current: usize) -> Option<(Vec<Knot>, Vec<Segment>)> {
        // Positions that differ are all that is looked at.
        let marks: Vec<[[f32; 3]; 1]> = (0..views.len()).map(|place| [[place as f32, 0.0, 0.0]]).collect();
        let poses =
            views.iter().zip(&marks).map(|(frame, mark)| Pose { positions: mark, view: &frame.view, cut: false });
        let poses: Vec<Pose> = poses.collect();
        let frame = views.get(current)?.frame;
        let window = Window { frame, poses: &poses, current, between: &[] };
        self.knots_between(&self.nearby(&window), &[])
    }

    fn knots_between(&self, window: &Window, cuts: &[usize]) -> Option<(Vec<Knot>, Vec<Segment>)> {
        let project = |pose: &Pose| self.project(window, pose);
        let after = window.current + 1;
        if after >= window.poses.len() || cuts.contains(&after) || !window.between.is_empty() {
            return None;
        }
        let timeline = timeline(window, cuts, self.settings.reach().ceil() as usize, project);
        let fits = timeline.knots.len() <= MOST_KNOTS && timeline.spans.len() <= PIECE_SEGMENTS as usize;
        if !fits || timeline.ends[0] == timeline.ends[1] {
            return None;
        }
        let times: Vec<f64> = timeline.knots.iter().map(|knot| knot.time).collect();
        let spline = Spline::new(&times, self.settings.trajectory);
        let mut weights = vec![[[0.0; 4]; PIECE_SEGMENTS as usize]; times.len()];
        for (place, span) in timeline.spans.iter().enumerate() {
            let [a, b] = span.knots;
            let squared = (times[b] - times[a]).powi(2);
            weights[b][place][1] += 1.0;
            weights[a][place][1] -= 1.0;
            // Frame i's own place is given as it is.
            weights[a][place][0] = if place == 0 { 0.0 } else { 1.0 };
            for (row, knot) in [(2, a), (3, b)] {
                let bend = spline.weights(knot);
                weights.iter_mut().zip(bend).for_each(|(all, weight)| all[place][row] = (squared * weight) as f32);
            }
        }
        let first = i64::from(window.frame) - window.current as i64;
        let knots = timeline.knots.iter().zip(weights).map(|(knot, weights)| {
            let same = |pose: &Pose| std::ptr::eq(pose.positions, knot.positions) && project(pose) == knot.projection;
            let place = window.poses.iter().position(same)?;
            let view = FrameView { frame: u32::try_from(first + place as i64).ok()?, view: *window.poses[place].view };
            Some(Knot { view, weights })
        });
        let segments = timeline.spans.iter().map(|span| span.segment).collect();
        Some((knots.collect::<Option<_>>()?, segments))
    }
}
