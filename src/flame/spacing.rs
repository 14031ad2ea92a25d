//! How far apart particles are: the usual radius of the space that a particle of fire fills.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::threads::together;

/// The neighbour whose distance counts.
const NEIGHBOURS: usize = 8;
/// The most points of a leaf.
const LEAF: usize = 12;
/// Parts that the points are divided into, on any number of processors, so that sums are the same on all.
const PARTS: usize = 64;

/// The most points whose neighbours are looked for: the mean over so many is good to a percent.
const MOST: usize = 8192;

/// Mean distance in metres from a point to its 8th nearest neighbour (the farthest there is, if there are fewer than
/// 9 points). Points that are not finite are left out; none with fewer than 2 points. Exact up to 8192 points; of more than that
/// it is the mean over some 8192 that are spread as all of them are, of whose neighbours none is left out.
///
/// A k-d tree: the time is O(n log n) also for points that are crowded together, or the same.
pub fn mean_spacing(positions: &[[f32; 3]]) -> Option<f32> {
    let finite = positions.iter().filter(|p| p.iter().all(|c| c.is_finite()));
    let mut points: Vec<[f64; 3]> = finite.map(|p| p.map(f64::from)).collect();
    if points.len() < 2 {
        return None;
    }
    let mut axes = vec![0; points.len()];
    arrange(&mut points, &mut axes);
    let neighbours = NEIGHBOURS.min(points.len() - 1);
    // In the order of the tree, which follows space.
    let step = points.len().div_ceil(MOST);
    let chosen: Vec<&[f64; 3]> = points.iter().skip(step / 2).step_by(step).collect();
    let size = chosen.len().div_ceil(PARTS);
    let sum_of = |part: usize| -> f64 {
        let own = chosen.iter().skip(part * size).take(size);
        own.map(|p| Search::new(**p, neighbours, &points, &axes).distance()).sum()
    };
    let (next, sum_of) = (AtomicUsize::new(0), &sum_of);
    let mut sums = vec![0.0; PARTS];
    let work = || -> Vec<(usize, f64)> {
        let parts = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed)).take_while(|part| *part < PARTS);
        parts.map(|part| (part, sum_of(part))).collect()
    };
    let threads = if points.len() < 1000 { 0 } else { std::thread::available_parallelism().map_or(1, |n| n.get()) - 1 };
    together(threads.min(PARTS), work).into_iter().flatten().for_each(|(part, sum)| sums[part] = sum);
    Some((sums.iter().sum::<f64>() / chosen.len() as f64) as f32)
}

/// Sorts points into a tree: the middle one splits the others along the axis in its place of `axes`, where they spread
/// farthest.
fn arrange(points: &mut [[f64; 3]], axes: &mut [u8]) {
    if points.len() <= LEAF {
        return;
    }
    let spread = |axis: usize| {
        let range = points.iter().fold([f64::MAX, f64::MIN], |[a, b], p| [a.min(p[axis]), b.max(p[axis])]);
        range[1] - range[0]
    };
    let spreads = [0, 1, 2].map(spread);
    let axis = if spreads[0] >= spreads[1].max(spreads[2]) { 0 } else { 1 + usize::from(spreads[2] > spreads[1]) };
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    axes[middle] = axis as u8;
    let ((left, right), (left_axes, right_axes)) = (points.split_at_mut(middle), axes.split_at_mut(middle));
    arrange(left, left_axes);
    arrange(&mut right[1..], &mut right_axes[1..]);
}

/// The nearest neighbours of one point. The point finds itself too, at distance 0: it is one more to find.
struct Search {
    point: [f64; 3],
    /// Squared distances found, ascending; infinite where none is yet.
    nearest: [f64; NEIGHBOURS + 1],
    /// Place of the last one that counts.
    last: usize,
}

impl Search {
    fn new(point: [f64; 3], neighbours: usize, points: &[[f64; 3]], axes: &[u8]) -> Search {
        let mut search = Search { point, nearest: [f64::INFINITY; NEIGHBOURS + 1], last: neighbours };
        search.visit(points, axes);
        search
    }

    fn distance(&self) -> f64 {
        self.nearest[self.last].sqrt()
    }

    fn visit(&mut self, points: &[[f64; 3]], axes: &[u8]) {
        if points.len() <= LEAF {
            points.iter().for_each(|p| self.meet(p));
            return;
        }
        let middle = points.len() / 2;
        let axis = usize::from(axes[middle]);
        let beyond = self.point[axis] - points[middle][axis];
        let (left, right) = ((&points[..middle], &axes[..middle]), (&points[middle + 1..], &axes[middle + 1..]));
        let (near, far) = if beyond < 0.0 { (left, right) } else { (right, left) };
        self.visit(near.0, near.1);
        if beyond * beyond < self.nearest[self.last] {
            self.meet(&points[middle]);
            self.visit(far.0, far.1);
        }
    }

    fn meet(&mut self, p: &[f64; 3]) {
        let squared: f64 = (0..3).map(|i| (p[i] - self.point[i]) * (p[i] - self.point[i])).sum();
        if squared >= self.nearest[self.last] {
            return;
        }
        let mut place = self.last;
        while place > 0 && self.nearest[place - 1] > squared {
            self.nearest[place] = self.nearest[place - 1];
            place -= 1;
        }
        self.nearest[place] = squared;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit};

    fn random(n: u32) -> Vec<[f32; 3]> {
        (0..n).map(|i| std::array::from_fn(|axis| unit(hash(5, i, 0, axis as u32)) * [1.0, 2.0, 0.1][axis])).collect()
    }

    fn by_comparing_all(points: &[[f32; 3]]) -> f64 {
        by_comparing_some(points, 1)
    }

    /// Of every so many.
    fn by_comparing_some(points: &[[f32; 3]], step: usize) -> f64 {
        let distances = points.iter().enumerate().step_by(step).map(|(i, p)| {
            let squared = |q: &[f32; 3]| (0..3).map(|a| (f64::from(p[a]) - f64::from(q[a])).powi(2)).sum::<f64>();
            let mut others: Vec<f64> = (0..points.len()).filter(|j| *j != i).map(|j| squared(&points[j])).collect();
            let eighth = 7.min(others.len() - 1);
            others.select_nth_unstable_by(eighth, f64::total_cmp).1.sqrt()
        });
        let distances: Vec<f64> = distances.collect();
        distances.iter().sum::<f64>() / distances.len() as f64
    }

    #[test]
    fn agrees_with_comparing_all() {
        for n in [2, 3, 8, 9, 10, 13, 200, 1500] {
            let points = random(n);
            let (found, exact) = (mean_spacing(&points).unwrap(), by_comparing_all(&points));
            assert!((f64::from(found) - exact).abs() < 1e-7, "{n}: {found} {exact}");
        }
    }

    #[test]
    fn some_of_many_stand_for_all() {
        // Dense in one place and thin in another.
        let mut points = random(20_000);
        points.iter_mut().for_each(|p| *p = p.map(|c| c * c * c));
        let (found, exact) = (mean_spacing(&points).unwrap(), by_comparing_some(&points, 7));
        assert!((f64::from(found) / exact - 1.0).abs() < 0.02, "{found} {exact}");
    }

    #[test]
    fn a_lattice_has_its_spacing() {
        // Far inside a cubic lattice, neighbours 7 to 18 are at sqrt 2.
        let points: Vec<[f32; 3]> =
            (0..27_000).map(|i| [i % 30, i / 30 % 30, i / 900].map(|c: u16| f32::from(c) * 0.5)).collect();
        let found = mean_spacing(&points).unwrap();
        assert!((0.5 * 2.0_f32.sqrt()..0.8).contains(&found), "{found}");
    }

    #[test]
    fn few_equal_or_infinite_points() {
        assert_eq!(mean_spacing(&[]), None);
        assert_eq!(mean_spacing(&[[1.0; 3]]), None);
        assert_eq!(mean_spacing(&[[1.0; 3], [f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]), None);
        assert_eq!(mean_spacing(&[[1.0; 3], [1.0, 1.0, 3.0], [f32::NAN; 3]]), Some(2.0));
        assert_eq!(mean_spacing(&vec![[3.0, 1.0, -2.0]; 100_000]), Some(0.0));
    }

    #[test]
    fn one_far_point_does_not_make_it_slow() {
        let mut points = random(100_000);
        points.push([1e9, 0.0, 0.0]);
        let start = std::time::Instant::now();
        assert!(mean_spacing(&points).unwrap() > 0.0);
        assert!(start.elapsed().as_secs() < 20);
    }
}
