//! Points that can be extreme: the convex hull, decided exactly, and what rounding can make as extreme as the hull.

use std::cmp::Ordering;
use std::ops::Range;

/// Half an ulp of 1 in f32.
const ROUNDING: f64 = 1.0 / 16_777_216.0;

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

/// A point beside the chain: the side that is nearest, how far along it the point is, and the point.
type Near = (usize, f64, [f32; 2]);

/// What hulls are found in.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Points that may be extreme, by x, and by y where that is the same.
    sorted: Vec<[f32; 2]>,
    /// Which of these are the convex hull, with what is on its sides.
    places: Vec<usize>,
    on_chain: Vec<bool>,
    /// The points at these places.
    chain: Vec<[f32; 2]>,
    near: Vec<Near>,
}

impl Scratch {
    /// Appends the extreme points of finite points, in the order of the outline, each once: the convex hull, counter-clockwise
    /// where y is up, with the points that are exactly on its sides, and after each of them the points so near to the side from
    /// it on that rounding in f32 can make them as extreme.
    pub(super) fn extremes(&mut self, points: &[[f32; 2]], found: &mut Vec<[f32; 2]>) {
        let Scratch { sorted, places, on_chain, chain, near } = self;
        // d.x * x + d.y * y errs by at most 2 roundings of |d| |p|; two points are compared.
        let farthest = points.iter().map(|[x, y]| f64::from(*x).hypot(f64::from(*y))).fold(0.0, f64::max);
        let band = 5.0 * ROUNDING * farthest;
        outside(points, 2.0 * band, sorted);
        sorted.sort_unstable_by(by_place);
        sorted.dedup();
        find_chain(sorted, places);
        chain.clear();
        chain.extend(places.iter().map(|place| sorted[*place]));
        if chain.len() == sorted.len() {
            found.extend_from_slice(chain);
            return;
        }
        on_chain.clear();
        on_chain.resize(sorted.len(), false);
        places.iter().for_each(|place| on_chain[*place] = true);
        let outline = Outline::new(chain);
        let rest = sorted.iter().zip(&*on_chain).filter(|(_, on)| !**on).map(|(point, _)| *point);
        near.clear();
        near.extend(rest.filter_map(|point| outline.side_of(point, band).map(|(side, along)| (side, along, point))));
        near.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(by_place(&a.2, &b.2)));
        let mut near = near.iter().peekable();
        for (side, point) in chain.iter().enumerate() {
            found.push(*point);
            while let Some((_, _, point)) = near.next_if(|next| next.0 == side) {
                found.push(*point);
            }
        }
    }
}

/// Orders points by x, and by y where that is the same.
fn by_place(a: &[f32; 2], b: &[f32; 2]) -> Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
}

/// Places of the hull of sorted points; of points on a line all.
fn find_chain(sorted: &[[f32; 2]], places: &mut Vec<usize>) {
    places.clear();
    extend_half(sorted, 0..sorted.len(), places);
    if places.len() < sorted.len() {
        // The upper half begins where the lower one ends, and ends where that begins.
        places.pop();
        extend_half(sorted, (0..sorted.len()).rev(), places);
        places.pop();
    }
}

/// A hull in quarters along which both coordinates change one way only.
struct Outline<'a> {
    chain: &'a [[f32; 2]],
    /// Sides of each, and what rises along them: the sum of both coordinates times these.
    quarters: [(Range<usize>, [f64; 2]); 4],
}

impl<'a> Outline<'a> {
    fn new(chain: &'a [[f32; 2]]) -> Outline<'a> {
        let mut quarters = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]].map(|signs| (0..0, signs));
        for side in 0..chain.len() {
            let [a, b] = [chain[side], chain[(side + 1) % chain.len()]];
            let quarter = match (b[0] > a[0], b[0] < a[0], b[1] > a[1], b[1] < a[1]) {
                (true, _, false, _) => 0,
                (_, false, true, _) => 1,
                (_, true, _, false) => 2,
                _ => 3,
            };
            let sides = &mut quarters[quarter].0;
            *sides = if sides.end == 0 { side..side + 1 } else { sides.start..side + 1 };
        }
        Outline { chain, quarters }
    }

    fn corner(&self, place: usize) -> [f64; 2] {
        self.chain[place % self.chain.len()].map(f64::from)
    }

    /// The side that is nearest to a point, if it is within `band`, and how far along it the point is.
    fn side_of(&self, point: [f32; 2], band: f64) -> Option<(usize, f64)> {
        let point = point.map(f64::from);
        let mut best = (1.01 * band, None);
        for (sides, [sx, sy]) in &self.quarters {
            let height = |p: [f64; 2]| sx * p[0] + sy * p[1];
            // The point of a side that is nearest is no farther away than that in each of two coordinates.
            let (least, most) = (height(point) - 2.1 * band, height(point) + 2.1 * band);
            let (mut first, mut end) = (sides.start, sides.end);
            while first < end {
                let middle = first.midpoint(end);
                if height(self.corner(middle + 1)) < least {
                    first = middle + 1;
                } else {
                    end = middle;
                }
            }
            for side in (first..sides.end).take_while(|side| height(self.corner(*side)) <= most) {
                let (distance, along) = to_side(self.corner(side), self.corner(side + 1), point);
                if distance < best.0 {
                    best = (distance, Some((side, along)));
                }
            }
        }
        best.1
    }
}

/// How far a point is from a side, and the place of the side that is nearest, from 0 to 1.
fn to_side(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> (f64, f64) {
    let [way, off] = [[b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]];
    let along = ((off[0] * way[0] + off[1] * way[1]) / (way[0] * way[0] + way[1] * way[1])).clamp(0.0, 1.0);
    ((off[0] - along * way[0]).hypot(off[1] - along * way[1]), along)
}

/// Appends half of the hull of sorted points: places of those that no later turn leaves to the left.
fn extend_half(sorted: &[[f32; 2]], order: impl Iterator<Item = usize>, places: &mut Vec<usize>) {
    let begin = places.len();
    for place in order {
        while let [.., a, b] = places[begin..]
            && side(sorted[a], sorted[b], sorted[place]) < 0.0
        {
            places.pop();
        }
        places.push(place);
    }
}

/// Finds the points that are not at least `margin` inside of the octagon of the extremes in 8 directions (Akl, Toussaint 1978).
fn outside(points: &[[f32; 2]], margin: f64, found: &mut Vec<[f32; 2]>) {
    const DIRECTIONS: [[f64; 2]; 8] =
        [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0], [0.0, -1.0], [1.0, -1.0]];
    found.clear();
    if points.len() < 64 {
        found.extend_from_slice(points);
        return;
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
    let (mut sides, mut count) = ([[0.0; 3]; DIRECTIONS.len()], 0);
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = dx.hypot(dy);
        if length > 0.0 {
            let normal = [-dy / length, dx / length];
            sides[count] = [normal[0], normal[1], normal[0] * a[0] + normal[1] * a[1] + margin];
            count += 1;
        }
    }
    let sides = &sides[..count];
    let inside = |point: &[f32; 2]| {
        let [x, y] = point.map(f64::from);
        sides.iter().all(|[nx, ny, least]| nx * x + ny * y > *least)
    };
    found.extend(points.iter().filter(|point| sides.is_empty() || !inside(point)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit};

    fn random(n: u32) -> Vec<[f32; 2]> {
        (0..n).map(|i| [0, 1].map(|axis| unit(hash(3, i, 0, axis)) - 0.5)).collect()
    }

    fn extremes(points: &[[f32; 2]]) -> Vec<[f32; 2]> {
        let mut found = Vec::new();
        Scratch::default().extremes(points, &mut found);
        found
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
        let expected = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0]];
        assert_eq!(extremes(&points), [&expected[..], &[[0.0, 1.0], [0.0, 0.5]]].concat());
    }

    #[test]
    fn few_points_and_lines_are_their_own_hull() {
        assert_eq!(extremes(&[]), Vec::<[f32; 2]>::new());
        assert_eq!(extremes(&[[3.0, 4.0]; 200]), [[3.0, 4.0]]);
        assert_eq!(extremes(&[[3.0, 4.0], [1.0, 2.0]]), [[1.0, 2.0], [3.0, 4.0]]);
        let line: Vec<[f32; 2]> = (0..500).map(|i| [i as f32, 2.0 * i as f32]).collect();
        assert_eq!(extremes(&line), line);
    }

    #[test]
    fn every_point_is_inside_and_the_filter_changes_nothing() {
        let ring = |p: &[f32; 2]| [2.0 * p[0], p[1]].iter().map(|c| c * c).sum::<f32>() < 0.25;
        for points in [random(5000), random(63), random(20_000).into_iter().filter(ring).collect()] {
            let found = extremes(&points);
            let mut sorted = found.clone();
            sorted.sort_by(by_place);
            let mut places = Vec::new();
            find_chain(&sorted, &mut places);
            let chain: Vec<[f32; 2]> = places.iter().map(|place| sorted[*place]).collect();
            for (a, b) in chain.iter().zip(chain.iter().cycle().skip(1)) {
                assert!(points.iter().all(|p| side(*a, *b, *p) >= 0.0));
            }
            assert!(found.len() < 400, "{}", found.len());
            let mut few = Vec::new();
            outside(&points[..60], 0.0, &mut few);
            assert_eq!(few.len(), 60);
        }
    }

    #[test]
    fn what_rounding_can_make_extreme_is_kept() {
        // A point that is 1e-4 below the upper side, where 5 roundings of the coordinates are 3e-3.
        let points = [[10_000.0, 0.0], [10_400.0, 0.0], [10_400.0, 100.0], [10_000.0, 100.0], [10_200.0, 99.9999]];
        let found = extremes(&points);
        assert_eq!(found, [points[0], points[1], points[2], points[4], points[3]]);
        let inner = [10_200.0, 99.9];
        assert_eq!(extremes(&[&points[..4], &[inner]].concat()).len(), 4);
    }

    /// Going around, products with any direction rise and fall once, but for twice as much as a point may be beside the
    /// outline; and no point that is left out has a larger one.
    #[test]
    fn the_order_is_that_of_the_outline() {
        let circle = |count: u32, radius: f32, squeeze: f32| -> Vec<[f32; 2]> {
            let at = |i: u32| f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            let point = |t: f64| [700.0 + radius * t.cos() as f32, 500.0 + squeeze * radius * t.sin() as f32];
            (0..count).map(|i| point(at(i * 7 % count))).collect()
        };
        let jitter = |i: u32, axis| (unit(hash(5, i, 1, axis)) - 0.5) * 2e-4;
        let line = |way: [f32; 2]| -> Vec<[f32; 2]> {
            (0..4000).map(|i| [0, 1].map(|axis| 300.0 + 0.1 * i as f32 * way[axis] + jitter(i, axis as u32))).collect()
        };
        let sets = [
            circle(20_001, 500.0, 1.0),
            circle(20_001, 0.5, 1.0),
            circle(3000, 200.0, 1e-6),
            line([1.0, 0.0]),
            line([0.0, 1.0]),
            line([0.7, -0.4]),
            random(20_000),
        ];
        for points in sets {
            let found = extremes(&points);
            let farthest = points.iter().map(|[x, y]| x.abs() + y.abs()).fold(0.0, f32::max);
            let margin = f64::from(farthest) * 1e-6;
            for turn in 0..400 {
                let (y, x) = (f64::from(turn) * 0.0157).sin_cos();
                let product = |p: &[f32; 2]| x * f64::from(p[0]) + y * f64::from(p[1]);
                let products: Vec<f64> = found.iter().map(product).collect();
                let top = (0..products.len()).max_by(|a, b| products[*a].total_cmp(&products[*b])).unwrap_or(0);
                let bottom = (0..products.len()).min_by(|a, b| products[*a].total_cmp(&products[*b])).unwrap_or(0);
                let falls = |places: Vec<usize>| {
                    let mut least = f64::MAX;
                    places.into_iter().all(|place| {
                        least = least.min(products[place]);
                        products[place] <= least + margin
                    })
                };
                let count = products.len();
                let steps = (bottom + count - top) % count;
                assert!(falls((0..=steps).map(|step| (top + step) % count).collect()));
                assert!(falls((0..=count - steps).map(|step| (top + count - step % count) % count).collect()));
                let single = |p: &[f32; 2]| x as f32 * p[0] + y as f32 * p[1];
                let most = |points: &[[f32; 2]]| points.iter().map(single).fold(f32::MIN, f32::max);
                assert_eq!(most(&found).to_bits(), most(&points).to_bits());
            }
        }
    }
}
