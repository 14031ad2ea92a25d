//! Points that can be extreme: the convex hull, decided exactly, and what rounding can make as extreme as the hull.

/// Half an ulp of 1 in f32.
const ROUNDING: f64 = 1.0 / 16_777_216.0;

/// Points of a set that can be extreme.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Extremes {
    /// The convex hull, counter-clockwise where y is up, with the points that are exactly on its sides; then the points
    /// so near to a side that rounding in f32 can make them as extreme. No point twice.
    pub(super) points: Vec<[f32; 2]>,
    /// Length of the hull.
    pub(super) chain: usize,
}

/// Whether c is to the left of the line from a to b (above 0), to its right (below 0) or on it (0). Exact: only the sign
/// counts.
pub(super) fn side(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f64 {
    let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(|p| p.map(f64::from));
    let (left, right) = ((ax - cx) * (by - cy), (ay - cy) * (bx - cx));
    let determinant = left - right;
    // Shewchuk 1997: beyond this bound the sign is that of the exact determinant.
    if determinant.abs() > 4.0 * f64::EPSILON * (left.abs() + right.abs()) {
        return determinant;
    }
    // Products of two floats are exact in f64, and c's with itself cancel.
    exact_sum([ax * by, -(ax * cy), -(cx * by), -(ay * bx), ay * cx, cy * bx])
}

/// The largest part of a sum as a sum of parts that do not overlap: it has the sum's sign.
fn exact_sum(terms: [f64; 6]) -> f64 {
    let mut parts = [0.0; 6];
    for (count, term) in terms.into_iter().enumerate() {
        let mut carry = term;
        for part in &mut parts[..count] {
            let sum = carry + *part;
            let of_part = sum - carry;
            *part = (carry - (sum - of_part)) + (*part - of_part);
            carry = sum;
        }
        parts[count] = carry;
    }
    parts.into_iter().rev().find(|part| *part != 0.0).unwrap_or(0.0)
}

/// The extreme points of finite points.
pub(super) fn extremes(points: &[[f32; 2]]) -> Extremes {
    // d.x * x + d.y * y errs by at most 2 roundings of |d| |p|; two points are compared.
    let farthest = points.iter().map(|[x, y]| f64::from(*x).hypot(f64::from(*y))).fold(0.0, f64::max);
    let band = 5.0 * ROUNDING * farthest;
    let mut sorted = outside(points, 2.0 * band);
    sorted.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    let lower = half(sorted.iter().copied().enumerate());
    if lower.len() == sorted.len() {
        return Extremes { chain: sorted.len(), points: sorted };
    }
    let upper = half(sorted.iter().copied().enumerate().rev());
    let mut on_chain = vec![false; sorted.len()];
    lower.iter().chain(&upper).for_each(|place| on_chain[*place] = true);
    let chain: Vec<[f32; 2]> =
        lower[..lower.len() - 1].iter().chain(&upper[..upper.len() - 1]).map(|place| sorted[*place]).collect();
    let rising: [Vec<[f32; 2]>; 2] =
        [lower.iter().map(|p| sorted[*p]).collect(), upper.iter().rev().map(|p| sorted[*p]).collect()];
    let rest = sorted.iter().zip(&on_chain).filter(|(_, on)| !**on).map(|(point, _)| *point);
    let near = rest.filter(|point| rising.iter().any(|chain| is_near(chain, *point, band)));
    let points: Vec<[f32; 2]> = chain.iter().copied().chain(near).collect();
    Extremes { chain: chain.len(), points }
}

/// Half of the hull of sorted points: places of those that no later turn leaves to the left.
fn half(points: impl Iterator<Item = (usize, [f32; 2])>) -> Vec<usize> {
    let (mut places, mut chain): (Vec<usize>, Vec<[f32; 2]>) = (Vec::new(), Vec::new());
    for (place, point) in points {
        while let [.., a, b] = chain[..]
            && side(a, b, point) < 0.0
        {
            chain.pop();
            places.pop();
        }
        chain.push(point);
        places.push(place);
    }
    places
}

/// Whether a point is within `band` of the line through a side of a chain, sorted by x, that is above or below it.
fn is_near(chain: &[[f32; 2]], point: [f32; 2], band: f64) -> bool {
    let [x, y] = point.map(f64::from);
    let first = chain.partition_point(|p| f64::from(p[0]) < x - band).saturating_sub(1);
    let sides = chain[first..].windows(2).take_while(|side| f64::from(side[0][0]) <= x + band);
    sides.into_iter().any(|side| {
        let [[ax, ay], [bx, by]] = [side[0], side[1]].map(|p| p.map(f64::from));
        let (dx, dy) = (bx - ax, by - ay);
        (dx * (y - ay) - dy * (x - ax)).abs() <= 1.001 * band * dx.hypot(dy)
    })
}

/// Points that are not at least `margin` inside of the octagon of the extremes in 8 directions (Akl, Toussaint 1978).
fn outside(points: &[[f32; 2]], margin: f64) -> Vec<[f32; 2]> {
    const DIRECTIONS: [[f64; 2]; 8] =
        [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0], [0.0, -1.0], [1.0, -1.0]];
    if points.len() < 64 {
        return points.to_vec();
    }
    let corner = |[dx, dy]: [f64; 2]| {
        let mut best = (f64::MIN, [0.0; 2]);
        for point in points {
            let [x, y] = point.map(f64::from);
            let along = dx * x + dy * y;
            if along > best.0 {
                best = (along, [x, y]);
            }
        }
        best.1
    };
    let corners = DIRECTIONS.map(corner);
    let mut sides = Vec::new();
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = dx.hypot(dy);
        if length > 0.0 {
            let normal = [-dy / length, dx / length];
            sides.push([normal[0], normal[1], normal[0] * a[0] + normal[1] * a[1] + margin]);
        }
    }
    let inside = |point: &[f32; 2]| {
        let [x, y] = point.map(f64::from);
        sides.iter().all(|[nx, ny, least]| nx * x + ny * y > *least)
    };
    points.iter().filter(|point| sides.is_empty() || !inside(point)).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::random::{hash, unit};

    fn random(n: u32) -> Vec<[f32; 2]> {
        (0..n).map(|i| [0, 1].map(|axis| unit(hash(3, i, 0, axis)) - 0.5)).collect()
    }

    #[test]
    fn sides_are_exact() {
        // Points on a line whose coordinates have up to 24 bits, and the same moved by one ulp.
        let on = |t: f32| [12_582_911.0 + t, 3.0 * t];
        assert_eq!(side(on(0.0), on(1.0), on(2.0)), 0.0);
        let tiny = f32::from_bits(1);
        assert!(side([0.0, 0.0], [1e30, 1e30], [1e30, 1e30_f32.next_up()]) > 0.0);
        assert!(side([0.0, 0.0], [1e30, 1e30], [1e30, 1e30_f32.next_down()]) < 0.0);
        assert!(side([0.0, 0.0], [1e30, 0.0], [-1e30, tiny]) > 0.0);
        assert!(side([0.0, 0.0], [1e30, 0.0], [-1e30, -tiny]) < 0.0);
        assert_eq!(side([-1e30, tiny], [1e30, tiny], [0.1, tiny]), 0.0);
        // What differences in f64 lose: c is 2^-60 of a pixel above the line y = x.
        let (far, near) = (1_073_741_824.0_f32, 2.0_f32.powi(-40));
        assert!(side([far; 2], [far.next_up(); 2], [near, near.next_up()]) > 0.0);
        assert!(side([far; 2], [far.next_up(); 2], [near, near.next_down()]) < 0.0);
        // Against integers: coordinates are multiples of 2^-10.
        for i in 0..20_000_u32 {
            let p: [[i64; 2]; 3] = std::array::from_fn(|k| {
                [0, 1].map(|axis| i64::from(hash(9, i, k as u32, axis) >> (8 + 7 * (i % 3))) - 4000)
            });
            let exact = (p[0][0] - p[2][0]) * (p[1][1] - p[2][1]) - (p[0][1] - p[2][1]) * (p[1][0] - p[2][0]);
            let [a, b, c] = p.map(|p| p.map(|c| c as f32 / 1024.0));
            if p.iter().flatten().all(|c| c.abs() < 1 << 24) {
                assert_eq!(side(a, b, c).partial_cmp(&0.0).unwrap() as i32, exact.signum() as i32, "{p:?}");
            }
        }
    }

    #[test]
    fn a_square_keeps_what_is_on_its_sides_and_nothing_twice() {
        let mut points = vec![[1.0, 1.0], [0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        points.extend([[1.0, 0.0], [2.0, 1.0], [0.0, 1.0], [1.0, 2.0], [2.0, 2.0], [0.0, 0.0], [0.0, 0.5]]);
        let found = extremes(&points);
        let expected = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0]];
        assert_eq!(found.points, [&expected[..], &[[0.0, 1.0], [0.0, 0.5]]].concat());
        assert_eq!(found.chain, 9);
    }

    #[test]
    fn few_points_and_lines_are_their_own_hull() {
        assert_eq!(extremes(&[]).points, Vec::<[f32; 2]>::new());
        assert_eq!(extremes(&[[3.0, 4.0]; 200]), Extremes { points: vec![[3.0, 4.0]], chain: 1 });
        assert_eq!(extremes(&[[3.0, 4.0], [1.0, 2.0]]).points, [[1.0, 2.0], [3.0, 4.0]]);
        let line: Vec<[f32; 2]> = (0..500).map(|i| [i as f32, 2.0 * i as f32]).collect();
        assert_eq!(extremes(&line), Extremes { points: line, chain: 500 });
    }

    #[test]
    fn every_point_is_inside_and_the_filter_changes_nothing() {
        let ring = |p: &[f32; 2]| [2.0 * p[0], p[1]].iter().map(|c| c * c).sum::<f32>() < 0.25;
        for points in [random(5000), random(63), random(20_000).into_iter().filter(ring).collect()] {
            let found = extremes(&points);
            for (a, b) in found.points[..found.chain].iter().zip(found.points[..found.chain].iter().cycle().skip(1)) {
                assert!(points.iter().all(|p| side(*a, *b, *p) >= 0.0));
            }
            assert!(found.points.len() < 400, "{}", found.points.len());
            assert_eq!(outside(&points[..60], 0.0).len(), 60);
        }
    }

    #[test]
    fn what_rounding_can_make_extreme_is_kept() {
        // A point that is 1e-4 below the upper side, where 5 roundings of the coordinates are 3e-3.
        let points = [[10_000.0, 0.0], [10_400.0, 0.0], [10_400.0, 100.0], [10_000.0, 100.0], [10_200.0, 99.9999]];
        let found = extremes(&points);
        assert_eq!((found.chain, found.points.len()), (4, 5));
        let inner = [10_200.0, 99.9];
        assert_eq!(extremes(&[&points[..4], &[inner]].concat()).points.len(), 4);
    }
}
