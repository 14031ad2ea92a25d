//! Which vertices of a file are one: those that are always at one place, and those that are shaded as one.

use std::collections::HashMap;
use std::hash::Hash;

use glam::Vec3;

use crate::data::Topology;

/// Without normals in the file, an edge sharper than this many degrees is hard (see [`shading_groups`]).
pub const CREASE: f32 = 40.0;

/// Finds the vertices of one object that are equal in all frames, a frame at a time.
#[derive(Clone, Debug)]
pub struct Welder {
    /// Point of each vertex so far; numbered by first occurrence.
    points: Vec<u32>,
    /// First vertex of each point.
    firsts: Vec<u32>,
}

impl Welder {
    /// Before any frame, all vertices of an object are one point. `object` has one number per vertex.
    pub fn new(object: &[u32]) -> Welder {
        let mut welder = Welder { points: vec![0; object.len()], firsts: vec![0; object.len().min(1)] };
        welder.split(|vertex| object[vertex]);
        welder
    }

    /// Takes apart what is not at one place in this frame; one position per vertex.
    pub fn refine(&mut self, positions: &[[f32; 3]]) {
        self.split(|vertex| place(positions[vertex]));
    }

    /// Takes vertices of different keys apart.
    pub(super) fn split<K: Hash + Eq>(&mut self, key: impl Fn(usize) -> K) {
        let together = |(vertex, &point): (usize, &u32)| {
            let first = self.firsts[point as usize] as usize;
            first == vertex || key(vertex) == key(first)
        };
        if self.points.iter().enumerate().all(together) {
            return;
        }
        let mut numbers = HashMap::with_capacity(self.firsts.len());
        self.firsts.clear();
        for (vertex, point) in self.points.iter_mut().enumerate() {
            *point = *numbers.entry((*point, key(vertex))).or_insert_with(|| {
                self.firsts.push(vertex as u32);
                self.firsts.len() as u32 - 1
            });
        }
    }

    /// Point of each vertex, numbered by first occurrence.
    pub fn finish(self) -> Vec<u32> {
        self.points
    }
}

/// A key of a position: that of -0 is that of 0. What is not a number does not get here.
pub(super) fn place(position: [f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
}

/// Point of each vertex, numbered by first occurrence: vertices of one object are one point if they are equal in all
/// frames. `object` and each frame have one row per vertex.
pub fn weld(object: &[u32], frames: &[Vec<[f32; 3]>]) -> Vec<u32> {
    let mut welder = Welder::new(object);
    frames.iter().for_each(|positions| welder.refine(positions));
    welder.finish()
}

/// Shading group of each vertex, numbered by first occurrence: vertices of one group have one smooth normal. They are of
/// one point and have the same normal in the file; or, where the file has none, their normals at rest (the area-weighted
/// mean of the triangles that use the vertex itself) are at most [`CREASE`] degrees from that of the group's first
/// vertex. A vertex that triangles on both sides of a hard edge share is in one group all the same: only the file could
/// tell it apart. What is flat ([`Topology::is_flat`]) is not looked at here. `points` is from [`weld()`], `rest` the positions of any one frame.
pub fn shading_groups(topology: &Topology, points: &[u32], rest: &[[f32; 3]]) -> Vec<u32> {
    let own = own_normals(topology, rest);
    let cosine = CREASE.to_radians().cos();
    let mut groups_of_point: HashMap<u32, Vec<(usize, u32)>> = HashMap::new();
    let mut count = 0;
    let mut groups = Vec::with_capacity(points.len());
    for (vertex, &point) in points.iter().enumerate() {
        let given = topology.normal[vertex];
        let same = |first: usize| match given == [0.0; 3] || topology.normal[first] == [0.0; 3] {
            true => given == topology.normal[first] && own[vertex].dot(own[first]) >= cosine,
            false => given == topology.normal[first],
        };
        let known = groups_of_point.entry(point).or_default();
        let found = known.iter().find(|(first, _)| same(*first)).map(|(_, group)| *group);
        groups.push(found.unwrap_or_else(|| {
            known.push((vertex, count));
            count += 1;
            count - 1
        }));
    }
    groups
}

/// Unit normal of each vertex from the triangles that use it; (0, 0, 0) where they have no area.
fn own_normals(topology: &Topology, rest: &[[f32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; rest.len()];
    for corners in &topology.triangles {
        let [a, b, c] = corners.map(|corner| Vec3::from(rest[corner as usize]));
        let area = (b - a).cross(c - a);
        corners.iter().for_each(|&corner| normals[corner as usize] += area);
    }
    normals.into_iter().map(Vec3::normalize_or_zero).collect()
}
