//! Trajectories in f64: splines through all frames, by elimination with the whole matrix.

use glam::{DVec2, DVec3};

use crate::blur::settings::Trajectory;
use crate::view::View;

/// Where a point is at a time, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Pixels, y down.
    pub position: DVec2,
    /// Pixels per frame.
    pub velocity: DVec2,
}

/// One point's poses in the frames of a shot, without cuts.
#[derive(Clone, Copy, Debug)]
pub struct Path<'a> {
    /// Its world position in each frame, at least one.
    pub positions: &'a [[f32; 3]],
    /// What each frame is seen through, in perspective.
    pub views: &'a [View],
    /// Whether the whole mesh, and the view, are in each frame as in the one before; false for the first.
    pub held: &'a [bool],
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Whether pixels are interpolated and not homogeneous coordinates.
    pub on_screen: bool,
    /// Whether the frames are all that will ever be, or those that are past.
    pub trajectory: Trajectory,
}

impl Path<'_> {
    /// Homogeneous pixel coordinates (x w, y w, w), or in screen space (x, y, w), in a frame.
    pub fn channels(&self, frame: usize) -> DVec3 {
        let (view, [width, height]) = (&self.views[frame], self.size.map(f64::from));
        let position = DVec3::from_array(self.positions[frame].map(f64::from));
        let clip = view.view_to_clip * (view.world_to_view * position.extend(1.0));
        let depth = clip.w / view.view_to_clip.row(3).truncate().length();
        let (x, y) = (0.5 * width * (clip.x / clip.w + 1.0), 0.5 * height * (clip.y / clip.w + 1.0));
        if self.on_screen { DVec3::new(x, y, depth) } else { DVec3::new(x * depth, y * depth, depth) }
    }

    /// The state at `time`, in frames after the first. Before the first frame and after the last paths are straight.
    pub fn at(&self, time: f64) -> State {
        let frames = self.positions.len();
        // The time axis without the frames in which the mesh is held.
        let moved = |frame: usize| (1..=frame).filter(|f| !self.held[*f]).count();
        let knots: Vec<DVec3> = (0..frames).filter(|f| !self.held[*f]).map(|f| self.channels(f)).collect();
        let frame = (time.floor().max(0.0) as usize).min(frames.saturating_sub(2));
        let still = frames == 1 || (self.held[frame + 1] && time >= 0.0 && time <= frames as f64 - 1.0);
        let t = if still { moved(frame) as f64 } else { moved(frame) as f64 + time - frame as f64 };
        let times: Vec<f64> = (0..knots.len()).map(|k| k as f64).collect();
        let [y, mut slope] = curve(&times, &knots, t, self.trajectory);
        if still {
            slope = DVec3::ZERO;
        }
        if self.on_screen {
            return State { position: y.truncate(), velocity: slope.truncate() };
        }
        let position = y.truncate() / y.z;
        let velocity = (slope.truncate() * y.z - y.truncate() * slope.z) / (y.z * y.z);
        State { position, velocity }
    }
}

/// Value and derivative at `t` of the cubic spline through `values` at ascending `times`; straight outside.
pub fn curve(times: &[f64], values: &[DVec3], t: f64, trajectory: Trajectory) -> [DVec3; 2] {
    if times.len() == 1 {
        return [values[0], DVec3::ZERO];
    }
    let bends = second_derivatives(times, values, trajectory);
    let last = times.len() - 2;
    let a = times[1..=last].iter().filter(|knot| **knot <= t).count();
    let inside = t.clamp(times[0], times[last + 1]);
    let h = times[a + 1] - times[a];
    let (to, from) = (times[a + 1] - inside, inside - times[a]);
    let value = (bends[a] * to.powi(3) + bends[a + 1] * from.powi(3)) / (6.0 * h)
        + (values[a] / h - bends[a] * (h / 6.0)) * to
        + (values[a + 1] / h - bends[a + 1] * (h / 6.0)) * from;
    let slope = (bends[a + 1] * (from * from) - bends[a] * (to * to)) / (2.0 * h)
        + (values[a + 1] - values[a]) / h
        + (bends[a] - bends[a + 1]) * (h / 6.0);
    [value + slope * (t - inside), slope]
}

/// Second derivatives at the knots, of which there are at least two: the whole system, rows of the ends included, by
/// elimination with pivots. At the ends they are 0; at the end of what is past, that of the knot before, if it is not the first.
pub fn second_derivatives(times: &[f64], values: &[DVec3], trajectory: Trajectory) -> Vec<DVec3> {
    let n = times.len();
    let mut rows: Vec<(Vec<f64>, DVec3)> = Vec::new();
    for i in 0..n {
        let mut row = vec![0.0; n];
        if i == 0 || i == n - 1 {
            row[i] = 1.0;
            if i > 1 && trajectory == Trajectory::Past {
                row[i - 1] = -1.0;
            }
            rows.push((row, DVec3::ZERO));
            continue;
        }
        let (left, right) = (times[i] - times[i - 1], times[i + 1] - times[i]);
        (row[i - 1], row[i], row[i + 1]) = (left, 2.0 * (left + right), right);
        rows.push((row, 6.0 * ((values[i + 1] - values[i]) / right - (values[i] - values[i - 1]) / left)));
    }
    for column in 0..n {
        let size = |row: &usize| rows[*row].0[column].abs();
        let Some(pivot) = (column..n).max_by(|a, b| size(a).total_cmp(&size(b))) else { break };
        rows.swap(column, pivot);
        let (row, right) = rows[column].clone();
        for (i, (other, other_right)) in rows.iter_mut().enumerate() {
            let factor = other[column] / row[column];
            if i != column && factor != 0.0 {
                other.iter_mut().zip(&row).for_each(|(a, b)| *a -= factor * b);
                *other_right -= factor * right;
            }
        }
    }
    rows.iter().enumerate().map(|(i, (row, right))| *right / row[i]).collect()
}
