//! Closed surfaces of a mesh: which triangles make one up, and which of their sides is outside.
//!
//! Which way the corners of a file's triangles go around says nothing: exporters differ, and mirrors turn all of them over.

use crate::shaders::blur::constants::NONE;
use crate::view::Projection;

/// Share of the largest coordinate by which rounding a position to f32 can move it, with room for sums over triangles.
const ROUNDING: f64 = 1.0 / 2_097_152.0;

/// The shells of a mesh. A *shell* is what hangs together over edges that two triangles share, if all of its edges are
/// such ones and all of its triangles can be turned so that any two run along their edge in opposite directions. Triangles
/// with two equal points are of no shell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shells {
    of_triangle: Vec<u32>,
    count: usize,
}

/// The solid that a shell encloses in a pose.
#[derive(Clone, Copy, Debug)]
pub struct Solid {
    /// Where its volume is measured from.
    origin: [f64; 3],
    /// Six times its volume, above 0 where its triangles run counter-clockwise seen from outside.
    volume: f64,
    /// At least twice the area of its triangles.
    area: f64,
    /// Its box.
    low: [f32; 3],
    high: [f32; 3],
}

impl Shells {
    /// The shells of other triangles, after these.
    pub fn append(&mut self, other: &Shells) {
        let shell = |shell: &u32| if *shell == NONE { NONE } else { shell + self.count as u32 };
        self.of_triangle.extend(other.of_triangle.iter().map(shell));
        self.count += other.count;
    }

    /// Finds the shells, and which triangles must be turned over so that all that hang together run as the first of them.
    /// A surface that can't be turned so, as a Moebius strip, stays as it is.
    pub fn find(triangles: &[[u32; 3]]) -> (Shells, Vec<bool>) {
        let (links, mut is_open) = links(triangles);
        let mut of_triangle = vec![NONE; triangles.len()];
        let mut turned = vec![false; triangles.len()];
        let mut seen = vec![false; triangles.len()];
        let (mut count, mut part) = (0, Vec::new());
        for first in 0..triangles.len() {
            if seen[first] || is_degenerate(&triangles[first]) {
                continue;
            }
            part.clear();
            part.push(first as u32);
            seen[first] = true;
            let (mut next, mut is_closed, mut is_two_sided) = (0, true, true);
            while let Some(&triangle) = part.get(next) {
                next += 1;
                let triangle = triangle as usize;
                is_closed &= !std::mem::take(&mut is_open[triangle]);
                for link in links[triangle].into_iter().flatten() {
                    let (other, wanted) = (link.triangle as usize, turned[triangle] != link.is_against);
                    if seen[other] {
                        is_two_sided &= turned[other] == wanted;
                    } else {
                        (seen[other], turned[other]) = (true, wanted);
                        part.push(link.triangle);
                    }
                }
            }
            match (is_two_sided, is_closed) {
                (false, _) => part.iter().for_each(|triangle| turned[*triangle as usize] = false),
                (true, false) => {}
                (true, true) => {
                    part.iter().for_each(|triangle| of_triangle[*triangle as usize] = count);
                    count += 1;
                }
            }
        }
        (Shells { of_triangle, count: count as usize }, turned)
    }

    /// The shell of a triangle.
    pub fn of(&self, triangle: usize) -> Option<usize> {
        Some(self.of_triangle[triangle]).filter(|shell| *shell != NONE).map(|shell| shell as usize)
    }

    /// The solid that each shell encloses, in the place of what is in `solids`. `triangles` are those that the shells were
    /// found of, and all turned over that had to be; one position a point.
    pub fn find_solids(&self, triangles: &[[u32; 3]], positions: &[[f32; 3]], solids: &mut Vec<Solid>) {
        let nothing = Solid {
            origin: [f64::NAN; 3],
            volume: 0.0,
            area: 0.0,
            low: [f32::INFINITY; 3],
            high: [f32::NEG_INFINITY; 3],
        };
        solids.clear();
        solids.resize(self.count, nothing);
        for (corners, shell) in triangles.iter().zip(&self.of_triangle) {
            if let Some(solid) = solids.get_mut(*shell as usize) {
                solid.add(corners.map(|point| positions[point as usize]));
            }
        }
    }
}

impl Solid {
    fn add(&mut self, corners: [[f32; 3]; 3]) {
        for corner in corners {
            self.low = [0, 1, 2].map(|axis| self.low[axis].min(corner[axis]));
            self.high = [0, 1, 2].map(|axis| self.high[axis].max(corner[axis]));
        }
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        if self.origin[0].is_nan() {
            self.origin = a;
        }
        let less = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let (p, q, from) = (less(b, a), less(c, a), less(a, self.origin));
        let normal = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
        self.volume += from[0] * normal[0] + from[1] * normal[1] + from[2] * normal[2];
        self.area += normal[0].abs() + normal[1].abs() + normal[2].abs();
    }

    /// Whether its triangles run clockwise seen from outside. None where that can't be told: it is so flat that rounding of
    /// its positions decides.
    pub fn is_turned(&self) -> Option<bool> {
        let farthest = self.low.iter().chain(&self.high).fold(0.0, |most: f64, x| most.max(f64::from(x.abs())));
        (self.volume.abs() > ROUNDING * farthest * self.area).then_some(self.volume < 0.0)
    }

    /// Whether its inside may be seen in pictures of `size` pixels: what is at least as near to the eye as the corners of the
    /// near plane is in its box.
    pub fn may_hold(&self, projection: &Projection, size: [u32; 2]) -> bool {
        let farther = |slopes: [f64; 2]| slopes[0].abs().max(slopes[1].abs());
        let [low, high] = projection.borders(size);
        let across = farther([low.x, high.x]) + farther([low.y, high.y]);
        let reach = projection.near + projection.widening(projection.near) * across;
        let eye = projection.eye.to_array();
        (0..3).all(|axis| {
            f64::from(self.low[axis]) - reach <= eye[axis] && eye[axis] <= f64::from(self.high[axis]) + reach
        })
    }
}

/// A triangle at the other side of an edge.
#[derive(Clone, Copy, Debug)]
struct Link {
    triangle: u32,
    /// Whether both run along the edge in the same direction: one of them must be turned over.
    is_against: bool,
}

fn is_degenerate([a, b, c]: &[u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// The neighbours of each triangle at its edges, and whether one of these is not shared by exactly two.
fn links(triangles: &[[u32; 3]]) -> (Vec<[Option<Link>; 3]>, Vec<bool>) {
    let mut sides: Vec<(u32, u32, u32, u8, bool)> = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in (0..).zip(triangles).filter(|(_, corners)| !is_degenerate(corners)) {
        let [a, b, c] = *corners;
        for (side, (from, to)) in (0..).zip([(a, b), (b, c), (c, a)]) {
            sides.push((from.min(to), from.max(to), triangle, side, from < to));
        }
    }
    sides.sort_unstable();
    let mut links = vec![[None; 3]; triangles.len()];
    let mut is_open = vec![false; triangles.len()];
    for edge in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        match edge {
            [one, other] => {
                for (own, other) in [(one, other), (other, one)] {
                    let link = Link { triangle: other.2, is_against: own.4 == other.4 };
                    links[own.2 as usize][own.3 as usize] = Some(link);
                }
            }
            _ => edge.iter().for_each(|side| is_open[side.2 as usize] = true),
        }
    }
    (links, is_open)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;
    use glam::DVec3;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

    /// The triangles of two tetrahedra, the second of points 4 to 7.
    fn pair() -> Vec<[u32; 3]> {
        let second = TETRAHEDRON.map(|t| t.map(|point| point + 4));
        [TETRAHEDRON, second].concat()
    }

    fn shells_of(triangles: &[[u32; 3]]) -> Vec<Option<usize>> {
        let shells = Shells::find(triangles).0;
        (0..triangles.len()).map(|triangle| shells.of(triangle)).collect()
    }

    fn only_solid(positions: &[[f32; 3]; 4]) -> Solid {
        let mut solids = Vec::new();
        Shells::find(&TETRAHEDRON).0.find_solids(&TETRAHEDRON, positions, &mut solids);
        solids[0]
    }

    #[test]
    fn what_hangs_together_and_has_no_border_is_a_shell() {
        assert_eq!(shells_of(&pair()), [0, 0, 0, 0, 1, 1, 1, 1].map(Some));
        assert_eq!(shells_of(&pair()[1..]), [None, None, None, Some(0), Some(0), Some(0), Some(0)]);
        // A fin, one without area, and two that share an edge, at which four triangles meet.
        assert_eq!(shells_of(&[&TETRAHEDRON[..], &[[0, 1, 4]]].concat()), [None; 5]);
        assert_eq!(shells_of(&[&TETRAHEDRON[..], &[[0, 1, 1]]].concat()), [Some(0), Some(0), Some(0), Some(0), None]);
        let touching: Vec<[u32; 3]> =
            pair().iter().map(|t| t.map(|p| if p > 3 && p < 6 { p - 4 } else { p })).collect();
        assert_eq!(shells_of(&touching), [None; 8]);
        assert_eq!(shells_of(&[]), []);
    }

    #[test]
    fn triangles_that_hang_together_are_turned_as_the_first_of_them() {
        for mask in 0..16_u32 {
            let turns = |triangle: usize| mask >> triangle & 1 == 1;
            let mut triangles = TETRAHEDRON;
            triangles.iter_mut().enumerate().filter(|(i, _)| turns(*i)).for_each(|(_, t)| t.swap(0, 1));
            let (shells, turned) = Shells::find(&triangles);
            let expected: Vec<bool> = (0..4).map(|triangle| turns(triangle) != turns(0)).collect();
            assert_eq!(turned, expected, "{mask}");
            assert!((0..4).all(|triangle| shells.of(triangle) == Some(0)), "{mask}");
            // The same of what has a border.
            assert_eq!(Shells::find(&triangles[..3]).1, expected[..3], "{mask}");
        }
    }

    #[test]
    fn what_has_one_side_stays_as_it_is() {
        // A Moebius strip of five triangles, and the projective plane: closed, of six points.
        let strip: Vec<[u32; 3]> = (0..5).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
        let plane = [
            [0, 1, 2],
            [0, 2, 3],
            [0, 3, 4],
            [0, 4, 5],
            [0, 5, 1],
            [1, 2, 4],
            [2, 3, 5],
            [3, 4, 1],
            [4, 5, 2],
            [5, 1, 3],
        ];
        for triangles in [&strip[..], &plane] {
            let (shells, turned) = Shells::find(triangles);
            assert_eq!(turned, vec![false; triangles.len()]);
            assert!((0..triangles.len()).all(|triangle| shells.of(triangle).is_none()));
        }
    }

    #[test]
    fn a_volume_tells_the_outside_and_a_flat_one_does_not() {
        let solid = |scale: [f32; 3], offset: f32| {
            only_solid(&CORNERS.map(|corner| [0, 1, 2].map(|axis| corner[axis] * scale[axis] + offset)))
        };
        assert_eq!(solid([1.0; 3], 0.0).volume, 1.0);
        assert_eq!(solid([2.0, 1.0, 1.0], 5.0).is_turned(), Some(false));
        assert_eq!(solid([-2.0, 1.0, 1.0], 5.0).is_turned(), Some(true));
        assert_eq!(solid([1.0, -1.0, -1.0], -700.0).is_turned(), Some(false));
        for flat in [0.0, 1e-5, -1e-5] {
            assert_eq!(solid([1.0, flat, 1.0], 100.0).is_turned(), None, "{flat}");
        }
        assert_eq!(solid([1.0, -1e-5, 1.0], 0.0).is_turned(), Some(true));
    }

    #[test]
    fn an_eye_in_the_box_may_see_the_inside() {
        let solid = only_solid(&CORNERS);
        let held = |eye: DVec3, near: f64| {
            let camera = Camera { eye, near, vertical_fov: 90.0, ..Camera::default() };
            solid.may_hold(&Projection::of_valid(&camera.view([200, 100]), [200, 100]), [200, 100])
        };
        assert!(held(DVec3::splat(0.5), 0.01));
        assert!(!held(DVec3::new(0.5, 0.5, 1.2), 0.01));
        // The near plane's corners are 1 * sqrt(1 + 1 + 4) of its distance away.
        assert!(held(DVec3::new(0.5, 0.5, 1.24), 0.1));
        assert!(!held(DVec3::new(0.5, 0.5, 1.5), 0.1));
    }
}
