//! Cubic splines through poses.

use crate::blur::settings::Trajectory;

/// The factorised matrix of the spline through knots at ascending times: gives second derivatives as weighted sums of what
/// is interpolated. At the ends they are 0; at the last knot of what is past, that of the knot before, which is exact where things
/// are accelerated evenly. At a break they are 0 too: what lies on both sides of it knows nothing of each other.
#[derive(Clone, Debug, Default)]
pub(super) struct Spline {
    /// Steps between the knots.
    steps: Vec<f64>,
    /// Each row's diagonal once the row above is eliminated, for the knots between the ends; infinite at a break.
    pivots: Vec<f64>,
    /// The knot before the end, if it has the end's second derivative.
    run_out: Option<usize>,
    /// A row of the inverse.
    row: Vec<f64>,
    /// What was asked for last.
    weights: Vec<f64>,
}

impl Spline {
    /// Becomes that of knots at these times, of which some are breaks.
    pub(super) fn renew(&mut self, mut knots: impl Iterator<Item = (f64, bool)>, trajectory: Trajectory) {
        let Spline { steps, pivots, run_out, .. } = self;
        steps.clear();
        pivots.clear();
        let Some(mut last) = knots.next() else { return };
        for knot in knots {
            let step = knot.0 - last.0;
            if let Some(before) = steps.last() {
                pivots.push(if last.1 { f64::INFINITY } else { 2.0 * (before + step) });
            }
            steps.push(step);
            last = knot;
        }
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
        if knot == 0 || knot > rows || pivots[knot - 1].is_infinite() {
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
        spline.renew(times.iter().map(|t| (*t, false)), trajectory);
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
