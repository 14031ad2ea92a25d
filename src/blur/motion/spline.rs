//! Cubic splines through poses.

use super::projection::PixelClip;
use super::window::{Pose, Segment, WINDOW, Window};
use crate::blur::settings::Trajectory;

/// A pose that trajectories go through. Equal poses that follow each other are one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    /// Frames after the first knot, without those in which the mesh is held.
    pub(super) time: f64,
    /// Its place, as [`Window::pose`] takes it: the first of the equal poses.
    pub(super) pose: usize,
    pub(super) projection: PixelClip,
}

/// A segment of the trajectories and the knots at its ends: the same one twice where the mesh is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) segment: Segment,
    pub(super) knots: [usize; 2],
}

/// The knots of trajectories, and the segments that are looked at.
#[derive(Clone, Debug, Default)]
pub(super) struct Timeline {
    pub(super) knots: Vec<Knot>,
    /// In the order of [`super::Interval::segments`].
    pub(super) spans: Vec<Span>,
    /// Knots of frames i and i + 1.
    pub(super) ends: [usize; 2],
    /// All poses that are looked at, by their times.
    moments: Vec<Moment>,
}

/// A pose at a time in frames after frame i, and the knot that it is of.
#[derive(Clone, Copy, Debug)]
struct Moment {
    time: f64,
    pose: usize,
    knot: usize,
}

impl Moment {
    /// Of no knot yet.
    fn new(time: f64, pose: usize) -> Moment {
        Moment { time, pose, knot: 0 }
    }
}

/// Whether two poses show the same: positions bit for bit, and the view but for its jitter.
fn held(a: &Pose, b: &Pose) -> bool {
    let bits = |pose: &Pose| -> *const [f32; 3] { pose.positions.as_ptr() };
    let same = || bytemuck::cast_slice::<_, u8>(a.positions) == bytemuck::cast_slice::<_, u8>(b.positions);
    a.view.without_jitter() == b.view.without_jitter() && (bits(a) == bits(b) || same())
}

impl Timeline {
    /// Becomes that of a window in which trajectories are cut before the poses of `cuts`, in ascending order, and looked at
    /// from `earlier` frames before frame i to frame i + 1, which must be there and not behind a cut.
    pub(super) fn renew(
        &mut self,
        window: &Window,
        cuts: &[usize],
        earlier: usize,
        project: impl Fn(&Pose) -> PixelClip,
    ) {
        let (i, count) = (window.current, window.poses.len());
        let begin = cuts.iter().rev().copied().find(|cut| *cut <= i).unwrap_or(0);
        let end = cuts.iter().copied().find(|cut| *cut > i).unwrap_or(count);
        let before = until(WINDOW + earlier, &window.poses[i], window.poses[begin..i].iter().rev());
        let after = until(WINDOW, &window.poses[i + 1], &window.poses[i + 2..end]);
        let at = |j: usize| Moment::new(j as f64 - i as f64, j);
        let parts = window.between.len() as f64 + 1.0;
        let between = (0..window.between.len()).map(|k| Moment::new((k + 1) as f64 / parts, count + k));
        self.moments.clear();
        self.moments.extend((i - before..=i).map(at).chain(between).chain((i + 1..i + 2 + after).map(at)));
        self.collapse(window, project);
        let moments = &self.moments;
        let span = |j: usize| Span {
            segment: Segment { begin: moments[j].time as f32, end: moments[j + 1].time as f32 },
            knots: [moments[j].knot, moments[j + 1].knot],
        };
        let (first, last) = (before, before + window.between.len() + 1);
        let back = (first.saturating_sub(earlier)..first).rev();
        self.spans.clear();
        self.spans.extend((first..last).chain(back).map(span));
        self.ends = [first, last].map(|end| moments[end].knot);
    }

    /// One knot for each run of equal poses.
    fn collapse(&mut self, window: &Window, project: impl Fn(&Pose) -> PixelClip) {
        self.knots.clear();
        let mut last: Option<Moment> = None;
        for moment in &mut self.moments {
            let pose = window.pose(moment.pose);
            if !last.is_some_and(|last| held(window.pose(last.pose), pose)) {
                let gone = last.map_or(0.0, |last| moment.time - last.time);
                let time = self.knots.last().map_or(0.0, |knot| knot.time + gone);
                self.knots.push(Knot { time, pose: moment.pose, projection: project(pose) });
            }
            moment.knot = self.knots.len() - 1;
            last = Some(*moment);
        }
    }

    /// Times from each knot to the next.
    pub(super) fn steps(&self) -> impl Iterator<Item = f64> {
        self.knots.windows(2).map(|pair| pair[1].time - pair[0].time)
    }

    /// Square of the time from one knot to the other.
    pub(super) fn squared(&self, [a, b]: [usize; 2]) -> f64 {
        (self.knots[b].time - self.knots[a].time).powi(2)
    }
}

/// How many of the poses that follow `first` come before its change number `count` + 1.
fn until<'a>(count: usize, first: &'a Pose<'a>, poses: impl IntoIterator<Item = &'a Pose<'a>>) -> usize {
    let (mut last, mut changes) = (first, 0);
    let is_within = |pose: &&'a Pose<'a>| {
        changes += usize::from(!held(last, pose));
        last = pose;
        changes <= count
    };
    poses.into_iter().take_while(is_within).count()
}

/// The factorised matrix of the spline through knots at ascending times: gives second derivatives as weighted sums of what
/// is interpolated. At the ends they are 0; at the last knot of what is past, that of the knot before, which is exact where things
/// are accelerated evenly.
#[derive(Clone, Debug, Default)]
pub(super) struct Spline {
    /// Steps between the knots.
    steps: Vec<f64>,
    /// Each row's diagonal once the row above is eliminated, for the knots between the ends.
    pivots: Vec<f64>,
    /// The knot before the end, if it has the end's second derivative.
    run_out: Option<usize>,
    /// A row of the inverse.
    row: Vec<f64>,
    /// What was asked for last.
    weights: Vec<f64>,
}

impl Spline {
    /// Becomes that of knots with these steps from each to the next.
    pub(super) fn renew(&mut self, between: impl Iterator<Item = f64>, trajectory: Trajectory) {
        let Spline { steps, pivots, run_out, .. } = self;
        steps.clear();
        steps.extend(between);
        pivots.clear();
        pivots.extend(steps.windows(2).map(|h| 2.0 * (h[0] + h[1])));
        *run_out = Some(pivots.len()).filter(|knot| trajectory == Trajectory::Past && *knot > 0);
        if let (Some(knot), Some(pivot)) = (*run_out, pivots.last_mut()) {
            *pivot += steps[knot];
        }
        for row in 1..pivots.len() {
            pivots[row] -= steps[row] * steps[row] / pivots[row - 1];
        }
    }

    /// Weights of all knots whose sum is the second derivative at `knot`; empty where it is 0.
    pub(super) fn weights(&mut self, knot: usize) -> &[f64] {
        let Spline { steps, pivots, run_out, row, weights } = self;
        let rows = pivots.len();
        let knot = run_out.map_or(knot, |last| knot.min(last));
        weights.clear();
        if knot == 0 || knot > rows {
            return weights;
        }
        // The matrix is symmetric: a row of its inverse is the solution for a unit vector.
        row.clear();
        row.resize(rows, 0.0);
        row[knot - 1] = 1.0;
        for j in knot..rows {
            row[j] = -row[j - 1] * steps[j] / pivots[j - 1];
        }
        for j in (0..rows).rev() {
            let next = if j + 1 < rows { steps[j + 1] * row[j + 1] } else { 0.0 };
            row[j] = (row[j] - next) / pivots[j];
        }
        weights.resize(rows + 2, 0.0);
        for (j, z) in row.iter().enumerate() {
            let [left, right] = [6.0 * z / steps[j], 6.0 * z / steps[j + 1]];
            weights[j] += left;
            weights[j + 1] -= left + right;
            weights[j + 2] += right;
        }
        weights
    }
}

/// Value and derivative by u of the cubic that is 0 at u = 0 and `step` at u = 1, with second derivatives `bends` there.
pub(super) fn offset(step: f64, bends: [f64; 2], u: f64) -> [f64; 2] {
    let c = 1.0 - u;
    let value = u * step + (c * c * c - c) / 6.0 * bends[0] + (u * u * u - u) / 6.0 * bends[1];
    let slope = step + (1.0 - 3.0 * c * c) / 6.0 * bends[0] + (3.0 * u * u - 1.0) / 6.0 * bends[1];
    [value, slope]
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::blur::reference::spline::curve;
    use crate::random::{hash, unit};

    /// Value at `t` of the spline through `values`, as the product finds it.
    fn at(times: &[f64], values: &[f64], t: f64) -> [f64; 2] {
        along(times, values, t, Trajectory::Spline)
    }

    fn along(times: &[f64], values: &[f64], t: f64, trajectory: Trajectory) -> [f64; 2] {
        let mut spline = Spline::default();
        spline.renew(times.windows(2).map(|t| t[1] - t[0]), trajectory);
        let a = (0..times.len() - 2).filter(|k| times[k + 1] <= t).count();
        let length = times[a + 1] - times[a];
        let mut bend = |knot| -> f64 { spline.weights(knot).iter().zip(values).map(|(w, v)| w * v).sum() };
        let bends = [a, a + 1].map(|knot| bend(knot) * length * length);
        let [value, slope] = offset(values[a + 1] - values[a], bends, (t - times[a]) / length);
        [values[a] + value, slope / length]
    }

    fn random(n: u32) -> Vec<f64> {
        (0..n).map(|i| f64::from(unit(hash(1, i, 0, 0))) * 565.0).collect()
    }

    #[test]
    fn agrees_with_elimination_of_the_whole_matrix() {
        for n in 2..14 {
            let values = random(n);
            let uneven: Vec<f64> = (0..n).map(|i| f64::from(i) + 0.8 * f64::from(unit(hash(2, i, 0, 0)))).collect();
            let even: Vec<f64> = (0..n).map(f64::from).collect();
            for (times, trajectory) in [
                (&even, Trajectory::Spline),
                (&uneven, Trajectory::Spline),
                (&even, Trajectory::Past),
                (&uneven, Trajectory::Past),
            ] {
                let vectors: Vec<DVec3> = values.iter().map(|v| DVec3::new(*v, 0.0, 0.0)).collect();
                for part in 0..=40 {
                    let t = times[0] + (times[n as usize - 1] - times[0]) * f64::from(part) / 40.0;
                    let (found, exact) = (along(times, &values, t, trajectory), curve(times, &vectors, t, trajectory));
                    assert!((found[0] - exact[0].x).abs() < 1e-10, "{n} {t}: {found:?} {exact:?}");
                    assert!((found[1] - exact[1].x).abs() < 1e-9, "{n} {t}: {found:?} {exact:?}");
                }
            }
        }
    }

    #[test]
    fn two_knots_are_a_line_and_three_have_their_closed_form() {
        assert_eq!(at(&[0.0, 1.0], &[3.0, 7.0], 0.25), [4.0, 4.0]);
        // 4 M = 6 (0 - 2 + 0) for 0, 1, 0.
        let (t, bend) = (0.5, -3.0);
        let exact = t + (t * t * t - t) / 6.0 * bend;
        assert!((at(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0], t)[0] - exact).abs() < 1e-15);
    }

    /// What is accelerated evenly stays so to the end of what is known.
    #[test]
    fn a_parabola_is_itself_up_to_the_last_past_frame() {
        let parabola = |t: f64| 3.5 * t * t - 11.0 * t + 2.0;
        let times: Vec<f64> = (0..14).map(f64::from).collect();
        let values: Vec<f64> = times.iter().map(|t| parabola(*t)).collect();
        for t in [12.0, 12.25, 12.5, 13.0] {
            let [value, slope] = along(&times, &values, t, Trajectory::Past);
            // 0.268^12 of the second derivative, which the first knot leaves out.
            assert!(
                (value - parabola(t)).abs() < 1e-6 && (slope - (7.0 * t - 11.0)).abs() < 5e-6,
                "{t}: {value} {slope}"
            );
        }
    }

    #[test]
    fn a_cubic_is_itself_far_from_the_ends() {
        let cubic = |t: f64| 0.25 * t * t * t - 2.0 * t * t + 7.0 * t - 3.0;
        let slope = |t: f64| 0.75 * t * t - 4.0 * t + 7.0;
        let times: Vec<f64> = (0..26).map(|i| f64::from(i) - 12.0).collect();
        let values: Vec<f64> = times.iter().map(|t| cubic(*t)).collect();
        for t in [0.0, 0.3, 0.5, 0.9] {
            let found = at(&times, &values, t);
            assert!((found[0] - cubic(t)).abs() < 1e-6 && (found[1] - slope(t)).abs() < 5e-6, "{t}: {found:?}");
        }
    }

    /// The largest difference at the middle of an interval between 12 poses to each side and all.
    fn windows_error(values: &[f64]) -> f64 {
        let times: Vec<f64> = (0..80).map(f64::from).collect();
        let errors = (12..66_usize).map(|i| {
            let whole = at(&times, values, i as f64 + 0.5);
            let window = at(&times[i - 12..i + 14], &values[i - 12..i + 14], i as f64 + 0.5);
            (whole[0] - window[0]).abs()
        });
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn a_window_is_the_whole_sequence_to_two_millionths_of_a_pixel() {
        // 565 pixels a frame at most, and a second derivative M of 220: the bound is 0.064 M 0.268^12.
        let smooth: Vec<f64> = (0..80).map(|i| 1449.0 * (0.39 * f64::from(i)).sin()).collect();
        let worst = windows_error(&smooth);
        assert!(worst < 2e-6, "{worst}");
        assert!(worst > 1e-7, "12 poses are not more than is needed by far: {worst}");
        // Noise of 565 pixels, whose second derivative is 12 times as large.
        let worst = windows_error(&random(80));
        assert!(worst < 2.5e-5, "{worst}");
    }
}
