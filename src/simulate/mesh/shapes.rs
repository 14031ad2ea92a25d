//! Closed surfaces of triangles about as long as asked for: boxes, and what a line makes that turns about the y axis.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DAffine3, DVec2, DVec3};

/// A surface: a normal and a colour per vertex, triangles counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
    pub(super) colours: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A point of a line that turns about the y axis: distance from the axis and height, the normal there, and a colour.
#[derive(Clone, Copy)]
struct Profile {
    at: DVec2,
    normal: DVec2,
    colour: [f32; 3],
}

/// How many pieces of about `edge` a length is cut into; at least `least`.
fn pieces(length: f64, edge: f64, least: u32) -> u32 {
    ((length / edge).round() as u32).max(least)
}

impl Shape {
    /// A box about the origin.
    pub(super) fn cuboid(half: DVec3, edge: f64, colour: [f32; 3]) -> Shape {
        let mut shape = Shape::default();
        let counts = [half.x, half.y, half.z].map(|half| pieces(2.0 * half, edge, 1));
        // The same on all faces that share an edge, to the bit.
        let along = |axis: usize, i: u32| half[axis] * (2.0 * f64::from(i) / f64::from(counts[axis]) - 1.0);
        for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let first = shape.positions.len() as u32;
            let mut normal = DVec3::ZERO;
            normal[axis] = side;
            for (j, i) in (0..=counts[v]).flat_map(|j| (0..=counts[u]).map(move |i| (j, i))) {
                let mut position = normal * half[axis];
                (position[u], position[v]) = (along(u, i), along(v, j));
                shape.push(position, normal, colour);
            }
            let row = counts[u] + 1;
            for (j, i) in (0..counts[v]).flat_map(|j| (0..counts[u]).map(move |i| (j, i))) {
                let [a, b, c, d] = [(j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)].map(|(j, i)| first + j * row + i);
                let halves = if side > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                shape.triangles.extend(halves);
            }
        }
        shape
    }

    /// A capsule from the origin down to y = -length, the centres of its ends, of two radii.
    pub(super) fn limb(upper: f64, lower: f64, length: f64, edge: f64, colour: [f32; 3]) -> Shape {
        // Where a sphere at each end meets the cone that touches both.
        let tilt = ((upper - lower) / length).clamp(-1.0, 1.0).asin();
        let (top, bottom) = (DVec2::ZERO, DVec2::new(0.0, -length));
        let mut profile = arc(bottom, lower, -FRAC_PI_2, -tilt, edge, colour);
        let end = arc(top, upper, -tilt, FRAC_PI_2, edge, colour);
        side(&mut profile, &end[..1], edge);
        profile.extend(end);
        revolve(&profile, pieces(TAU * upper.max(lower), edge, 6))
    }

    /// A ball about the origin.
    pub(super) fn ball(radius: f64, edge: f64, colour: [f32; 3]) -> Shape {
        let profile = arc(DVec2::ZERO, radius, -FRAC_PI_2, FRAC_PI_2, edge, colour);
        revolve(&profile, pieces(TAU * radius, edge, 6))
    }

    /// A cylinder about the y axis, its middle at the origin.
    pub(super) fn cylinder(radius: f64, height: f64, edge: f64, colour: [f32; 3]) -> Shape {
        let point = |x: f64, y: f64, normal: DVec2| Profile { at: DVec2::new(x, y), normal, colour };
        let half = height / 2.0;
        let mut profile = vec![point(0.0, -half, DVec2::NEG_Y)];
        for (end, normal) in [((radius, -half), DVec2::NEG_Y), ((radius, half), DVec2::X), ((0.0, half), DVec2::Y)] {
            if let Some(last) = profile.last().map(|last| Profile { normal, ..*last })
                && last.at.x > 0.0
            {
                profile.push(last);
            }
            let end = [point(end.0, end.1, normal)];
            side(&mut profile, &end, edge);
            profile.extend(end);
        }
        revolve(&profile, pieces(TAU * radius, edge, 6))
    }

    /// An upright capsule about the origin, `length` between the centres of its ends, in bands of two colours.
    pub(super) fn banded_capsule(radius: f64, length: f64, bands: u32, edge: f64, colours: [[f32; 3]; 2]) -> Shape {
        let colour = |band: u32| colours[band as usize % 2];
        let height = |band: u32| length * (f64::from(band) / f64::from(bands) - 0.5);
        let mut profile = arc(DVec2::new(0.0, height(0)), radius, -FRAC_PI_2, 0.0, edge, colour(0));
        for band in 0..bands {
            let at = |y: f64| Profile { at: DVec2::new(radius, y), normal: DVec2::X, colour: colour(band) };
            if band > 0 {
                profile.push(at(height(band)));
            }
            let end = [at(height(band + 1))];
            side(&mut profile, &end, edge);
            profile.extend(end);
        }
        let cap = arc(DVec2::new(0.0, height(bands)), radius, 0.0, FRAC_PI_2, edge, colour(bands - 1));
        profile.extend(&cap[1..]);
        revolve(&profile, pieces(TAU * radius, edge, 6))
    }

    /// The surface elsewhere.
    pub(super) fn moved(mut self, by: DAffine3) -> Shape {
        self.positions.iter_mut().for_each(|p| *p = by.transform_point3(*p));
        self.normals.iter_mut().for_each(|n| *n = by.transform_vector3(*n));
        self
    }

    fn push(&mut self, position: DVec3, normal: DVec3, colour: [f32; 3]) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.colours.push(colour);
        self.positions.len() as u32 - 1
    }
}

/// An arc about a centre from one angle to another, both from the horizontal.
fn arc(centre: DVec2, radius: f64, from: f64, to: f64, edge: f64, colour: [f32; 3]) -> Vec<Profile> {
    let count = pieces(radius * (to - from), edge, 2);
    let point = |i: u32| {
        let normal = DVec2::from_angle(from + (to - from) * f64::from(i) / f64::from(count));
        let at = centre + radius * normal;
        // On the axis exactly.
        let is_pole = normal.x.abs() < 1e-12;
        Profile { at: if is_pole { DVec2::new(0.0, at.y) } else { at }, normal, colour }
    };
    (0..=count).map(point).collect()
}

/// Adds the points of a straight line between the last one and `end`, without either.
fn side(profile: &mut Vec<Profile>, end: &[Profile], edge: f64) {
    let (Some(&from), Some(&to)) = (profile.last(), end.first()) else { return };
    let count = pieces(from.at.distance(to.at), edge, 1);
    let between = |i: u32| Profile { at: from.at.lerp(to.at, f64::from(i) / f64::from(count)), ..to };
    profile.extend((1..count).map(between));
}

/// The surface of a line that turns about the y axis, from its lower end on the axis to its upper one. Points of the
/// line at one place make a hard edge.
fn revolve(profile: &[Profile], around: u32) -> Shape {
    let mut shape = Shape::default();
    let mut before: Option<(DVec2, Vec<u32>)> = None;
    for &Profile { at, normal, colour } in profile {
        let count = if at.x == 0.0 { 1 } else { around };
        let ring: Vec<u32> = (0..count)
            .map(|i| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(around)).sin_cos();
                let out = |v: DVec2| DVec3::new(v.x * cos, v.y, v.x * sin);
                shape.push(out(at), out(normal), colour)
            })
            .collect();
        if let Some((last, below)) = &before
            && *last != at
        {
            let corner = |ring: &[u32], i: u32| ring[i as usize % ring.len()];
            for i in 0..around {
                let [a, b] = [i, i + 1].map(|i| corner(below, i));
                let [d, c] = [i, i + 1].map(|i| corner(&ring, i));
                shape
                    .triangles
                    .extend([[a, c, b], [a, d, c]].into_iter().filter(|[a, b, c]| a != b && b != c && a != c));
            }
        }
        before = Some((at, ring));
    }
    shape
}
