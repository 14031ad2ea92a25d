//! Ink by steps: of frames that are drawn, and of the distorted mesh.

use crate::shaders::blur::constants::STEEPEST;

/// What a sample sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The object, from 1; 0: nothing.
    pub object: u32,
    /// View depth as it is drawn, in metres.
    pub depth: f64,
    /// Where one frame has that surface, in samples, and its view depth there. Of a frame itself: the sample's own place and depth.
    pub place: [f64; 3],
}

/// How large the step from a sample down to those beside it is, in units of eight samples' footprints at its depth; a line is where
/// it is above 1. The largest over row, column and both diagonals of the sum over both sides: how much farther the same object
/// is there, but for [`STEEPEST`] times what its places are farther apart than the samples are. Infinite if nothing is there, or
/// another object that is not nearer; one that is nearer counts as no step.
///
/// `beside` is what the sample sees that is so many columns and rows away, the nearest one where that is outside of the picture;
/// `footprint` is the width of a sample in metres.
pub fn step(own: &Sample, footprint: f64, beside: impl Fn([i32; 2]) -> Sample) -> f64 {
    let mut largest: f64 = 0.0;
    for way in [[1, 0], [0, 1], [1, 1], [1, -1]] {
        let mut difference = 0.0;
        for side in [-1, 1] {
            let other = beside(way.map(|c| side * c));
            if other.object == 0 || (other.object != own.object && other.depth >= own.depth) {
                return f64::INFINITY;
            }
            if other.object == own.object {
                let [x, y, depth] = [0, 1, 2].map(|i| other.place[i] - own.place[i]);
                let apart = (x.hypot(y) - f64::from(way[0]).hypot(f64::from(way[1]))).max(0.0);
                let back = depth / (8.0 * footprint);
                difference += back.signum() * (back.abs() - f64::from(STEEPEST) / 8.0 * apart).max(0.0);
            }
        }
        largest = largest.max(difference);
    }
    largest
}

/// Opacity of ink at a sample: that of the nearest line, fading over the last sample of its width. `line` says whether there is one
/// so many columns and rows away.
pub fn opacity(width: f64, line: impl Fn([i32; 2]) -> bool) -> f64 {
    let reach = width.ceil() as i32 - 1;
    let ways = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
    let share = |[x, y]: [i32; 2]| (width - f64::from(x).hypot(f64::from(y))).clamp(0.0, 1.0);
    ways.filter(|way| line(*way)).map(share).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOOTPRINT: f64 = 0.01;

    /// Of a row of samples, of depths; the same below and above.
    fn step_of(depths: [f64; 3], objects: [u32; 3], apart: f64) -> f64 {
        let sample = |column: i32, row: i32| {
            let (depth, object) = (depths[(column + 1) as usize], objects[(column + 1) as usize]);
            Sample { object, depth, place: [f64::from(column) * apart, f64::from(row), depth] }
        };
        step(&sample(0, 0), FOOTPRINT, |[x, y]| sample(x, y))
    }

    #[test]
    fn the_nearer_side_of_a_step_has_the_line() {
        let unit = 8.0 * FOOTPRINT;
        assert!((step_of([1.0, 1.0, 1.0 + 2.0 * unit], [1; 3], 1.0) - 2.0).abs() < 1e-9);
        assert_eq!(step_of([1.0, 1.0 + 2.0 * unit, 1.0 + 2.0 * unit], [1; 3], 1.0), 0.0);
        // A slope is none, however steep.
        assert!(step_of([1.0, 2.0, 3.0], [1; 3], 1.0) < 1e-9);
        // Samples that see places far apart: the same surface, if it is no steeper than 2.
        assert!(step_of([1.0, 1.0, 1.0 + 1.9 * FOOTPRINT * 9.0], [1; 3], 10.0) <= 0.0);
        assert!(step_of([1.0, 1.0, 1.0 + 3.0 * FOOTPRINT * 99.0], [1; 3], 100.0) > 1.0);
    }

    #[test]
    fn objects_and_nothing_end_with_a_line_on_the_nearer_side() {
        assert_eq!(step_of([1.0, 1.0, 1.5], [1, 1, 2], 1.0), f64::INFINITY);
        assert_eq!(step_of([1.0, 1.0, 0.5], [1, 1, 2], 1.0), 0.0);
        assert_eq!(step_of([1.0, 1.0, f64::INFINITY], [1, 1, 0], 1.0), f64::INFINITY);
    }

    #[test]
    fn a_line_is_as_broad_as_is_asked() {
        let at = |column: i32, width: f64| opacity(width, |[x, _]| x == column);
        assert_eq!([0, 1, 2, 3].map(|column| at(column, 2.5)), [1.0, 1.0, 0.5, 0.0]);
        assert_eq!([0, 1].map(|column| at(column, 1.0)), [1.0, 0.0]);
    }
}
