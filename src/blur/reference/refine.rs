//! Refinement: triangles are bisected where the distorted mesh departs from them. In f32, each operation rounded by
//! itself, in this order.

use super::extent::{Extent, Pull, extent_in};
use super::path::{Path, State};
use crate::blur::mesh::Mesh;
use crate::blur::motion::{Interval, Piece};
use crate::blur::params::{BETWEEN, LEAST_EDGE, LEAST_SURFACE, ROUNDS, USUAL_ROUNDS};
use crate::blur::settings::{Refine, Settings, Space};

/// Rules of the refinement.
#[derive(Clone, Copy, Debug)]
pub struct Rules<'a> {
    /// The interval that is drawn.
    pub interval: &'a Interval,
    /// The effect's settings.
    pub settings: &'a Settings,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// The shot's seed.
    pub seed: u32,
    /// The most triangles.
    pub budget: usize,
}

/// A vertex of the refined mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Vertex {
    /// Its trajectory: a piece of each segment.
    pub pieces: Vec<Piece>,
    /// Position and velocity at the reference time.
    pub motion: [f32; 4],
    /// Its place in its cluster, and its time.
    pub extent: Extent,
    /// Its cluster, from 1; 0: none, [`BETWEEN`].
    pub label: u32,
    /// Where it is drawn, in pixels.
    pub drawn: [f32; 2],
    /// View depth there in metres.
    pub depth: f32,
}

/// A triangle of the refined mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Its vertices.
    pub corners: [u32; 3],
    /// The mesh's triangle that it is a part of.
    pub base: u32,
    /// Barycentric coordinates of its corners in that.
    pub weights: [[f32; 3]; 3],
}

/// The refined mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// The mesh's points, then those that were added; each triangle has its own of the latter.
    pub vertices: Vec<Vertex>,
    /// The triangles, in the order of the mesh's.
    pub triangles: Vec<Triangle>,
    /// Rounds that split something.
    pub rounds: u32,
    /// Whether the budget did not suffice for a round.
    pub over_budget: bool,
}

/// Refines the mesh, of whose points `extents` are known.
pub fn refine(mesh: &Mesh, extents: &[Extent], rules: &Rules) -> Refined {
    let (points, segments) = (mesh.points(), rules.interval.segments.len());
    let vertex = |p: usize| {
        let pieces: Vec<Piece> = (0..segments).map(|s| rules.interval.pieces[s * points + p]).collect();
        let State { position: drawn, depth, .. } = rules.path(&pieces).at(extents[p].time);
        let (motion, label) = (rules.interval.motion[p], rules.interval.labels[p]);
        Vertex { pieces, motion, extent: extents[p], label, drawn, depth }
    };
    let whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let base = |(corners, base): (&[u32; 3], u32)| Triangle { corners: *corners, base, weights: whole };
    let mut refined = Refined {
        vertices: (0..points).map(vertex).collect(),
        triangles: mesh.triangles().iter().zip(0..).map(base).collect(),
        ..Refined::default()
    };
    loop {
        let split: Vec<[bool; 3]> = refined.triangles.iter().map(|t| rules.split(&refined, t)).collect();
        let more = split.iter().flatten().filter(|split| **split).count();
        refined.over_budget = refined.triangles.len() + more > rules.budget;
        if more == 0 || refined.rounds == ROUNDS || refined.over_budget {
            return refined;
        }
        let triangles = std::mem::take(&mut refined.triangles);
        triangles.iter().zip(split).for_each(|(triangle, split)| rules.divide(&mut refined, triangle, split));
        refined.rounds += 1;
    }
}

impl<'a> Rules<'a> {
    /// What k' follows from.
    pub fn pull(&self) -> Pull<'a> {
        Pull { interval: self.interval, settings: self.settings, height: self.size[1], seed: self.seed }
    }

    fn path<'p>(&'p self, pieces: &'p [Piece]) -> Path<'p> {
        Path { segments: &self.interval.segments, pieces, on_screen: self.settings.space == Space::Screen }
    }

    /// The vertex in the middle between two.
    pub fn middle(&self, a: &Vertex, b: &Vertex) -> Vertex {
        let mean = |a: [f32; 4], b: [f32; 4]| [0, 1, 2, 3].map(|i| (a[i] + b[i]) * 0.5);
        let piece = |(a, b): (&Piece, &Piece)| Piece {
            origin: mean(a.origin, b.origin),
            step: mean(a.step, b.step),
            bend_begin: mean(a.bend_begin, b.bend_begin),
            bend_end: mean(a.bend_end, b.bend_end),
        };
        let pieces: Vec<Piece> = a.pieces.iter().zip(&b.pieces).map(piece).collect();
        let path = self.path(&pieces);
        let state = path.at(self.settings.reference_time);
        let ([x, y], [vx, vy]) = (state.position, state.velocity);
        let seen = [state.depth, path.at(0.0).depth, path.at(1.0).depth].iter().all(|depth| *depth > 0.0);
        let usable = seen && [x, y, vx, vy].iter().all(|c| c.is_finite());
        let of_parents = if a.label == b.label { a.label } else { BETWEEN };
        let (motion, label) = if usable { ([x, y, vx, vy], of_parents) } else { ([0.0; 4], 0) };
        let extent = self.extent(a, b, motion, label);
        let State { position: drawn, depth, .. } = path.at(extent.time);
        Vertex { pieces, motion, extent, label, drawn, depth }
    }

    /// The extent of the vertex between two.
    fn extent(&self, a: &Vertex, b: &Vertex, motion: [f32; 4], label: u32) -> Extent {
        let half = |of: fn(&Extent) -> f32| (of(&a.extent) + of(&b.extent)) * 0.5;
        let (offset, share) = (half(|extent| extent.offset), half(|extent| extent.share));
        if label == BETWEEN {
            let (k, l) = (half(|extent| extent.k), half(|extent| extent.l));
            return Extent { k, l, offset, time: half(|extent| extent.time), share };
        }
        let Some(cluster) = self.interval.cluster(label) else { return Extent { share, ..Extent::NONE } };
        let [k, l] = extent_in(motion, cluster, self.interval.bounds_of(cluster));
        let pull = self.pull();
        Extent { k, l, offset, time: pull.shifted(pull.time(cluster, [k, l], share), offset), share }
    }

    /// Whether the edge between two vertices is to be split in a round: the same for both orders.
    pub fn splits(&self, a: &Vertex, b: &Vertex, round: u32) -> bool {
        let squared = |p: [f32; 2], q: [f32; 2]| {
            let (x, y) = (p[0] - q[0], p[1] - q[1]);
            x * x + y * y
        };
        let length = squared(a.drawn, b.drawn);
        // Also where the length is not a number.
        if a.label.max(b.label) == 0 || !(LEAST_EDGE * LEAST_EDGE..f32::INFINITY).contains(&length) {
            return false;
        }
        let by_length = self.settings.refine == Refine::Length;
        let place = |vertex: &Vertex| [vertex.motion[0], vertex.motion[1]];
        if !by_length && squared(place(a), place(b)) < LEAST_SURFACE * LEAST_SURFACE {
            return false;
        }
        let [tolerance, edge] =
            [self.settings.tolerance, self.settings.edge].map(|pixels| Settings::scaled(pixels, self.size[1]));
        let late = 1 << (round.max(USUAL_ROUNDS) - USUAL_ROUNDS);
        let tolerance = tolerance * late as f32;
        let towards = |p: [f32; 2], q: [f32; 2]| [0, 1].map(|i| p[i] + (q[i] - p[i]) * 0.25);
        let middle = self.middle(a, b);
        let half = [0, 1].map(|i| (a.drawn[i] + b.drawn[i]) * 0.5);
        let quarters = [self.middle(a, &middle), self.middle(b, &middle)];
        let departures = [
            squared(middle.drawn, half),
            squared(quarters[0].drawn, towards(a.drawn, b.drawn)),
            squared(quarters[1].drawn, towards(b.drawn, a.drawn)),
        ];
        // What is not a number is not off.
        let departure = departures.into_iter().fold(0.0, |most, off| if off > most { off } else { most });
        let wanted = if by_length { length > edge * edge } else { departure > tolerance * tolerance };
        let far = self.beyond([a, b, &middle, &quarters[0], &quarters[1]]);
        wanted && far * far <= departure
    }

    /// How far all these vertices are beyond one border of the picture, in pixels; 0: they are not, or after-images are
    /// drawn of them, which may be inside.
    fn beyond(&self, vertices: [&Vertex; 5]) -> f32 {
        let [width, height] = self.size.map(|pixels| pixels as f32);
        let far = |vertex: &Vertex| match vertex.depth > 0.0 {
            true => [-vertex.drawn[0], -vertex.drawn[1], vertex.drawn[0] - width, vertex.drawn[1] - height],
            false => [-1.0; 4],
        };
        let all = vertices.map(far);
        let side = |i: usize| all.iter().map(|far| far[i]).fold(f32::INFINITY, f32::min);
        if self.settings.is_clipped() { [0, 1, 2, 3].map(side).into_iter().fold(0.0, f32::max) } else { 0.0 }
    }

    /// An edge that is not split in the round in which it comes up is not in later ones: their tolerances are larger.
    fn split(&self, refined: &Refined, triangle: &Triangle) -> [bool; 3] {
        let [a, b, c] = triangle.corners.map(|corner| &refined.vertices[corner as usize]);
        [[a, b], [b, c], [c, a]].map(|[a, b]| self.splits(a, b, refined.rounds))
    }

    /// Adds the parts of a triangle whose edges (first to second corner, second to third, third to first) are `split`.
    fn divide(&self, refined: &mut Refined, triangle: &Triangle, split: [bool; 3]) {
        // Turned so that the corners' order decides nothing: one split edge comes first, of two the edge that is whole is
        // in the middle.
        let turn = match split {
            [false, true, false] | [true, true, false] => 1,
            [false, false, true] | [false, true, true] => 2,
            _ => 0,
        };
        let turned = |i: usize| (i + turn) % 3;
        let corners: [Corner; 3] =
            std::array::from_fn(|i| Corner(triangle.corners[turned(i)], triangle.weights[turned(i)]));
        let split: [bool; 3] = std::array::from_fn(|i| split[turned(i)]);
        let [a, b, c] = corners;
        let mut middle = |i: usize| {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            let vertex = self.middle(&refined.vertices[p.0 as usize], &refined.vertices[q.0 as usize]);
            refined.vertices.push(vertex);
            Corner(refined.vertices.len() as u32 - 1, [0, 1, 2].map(|k| (p.1[k] + q.1[k]) * 0.5))
        };
        let parts = match split {
            [false, false, false] => vec![[a, b, c]],
            [true, false, false] => {
                let m = middle(0);
                vec![[a, m, c], [m, b, c]]
            }
            [true, false, true] => {
                let (m, n) = (middle(0), middle(2));
                match first_is_shorter(&refined.vertices, [m, c], [b, n]) {
                    true => vec![[a, m, n], [m, b, c], [m, c, n]],
                    false => vec![[a, m, n], [m, b, n], [b, c, n]],
                }
            }
            _ => {
                let (m, n, o) = (middle(0), middle(1), middle(2));
                vec![[a, m, o], [m, b, n], [o, n, c], [m, n, o]]
            }
        };
        refined.triangles.extend(parts.iter().map(|part| Triangle {
            corners: part.map(|corner| corner.0),
            base: triangle.base,
            weights: part.map(|corner| corner.1),
        }));
    }
}

/// A vertex, and its barycentric coordinates.
#[derive(Clone, Copy)]
struct Corner(u32, [f32; 3]);

/// Whether the first of two diagonals is the shorter one; of equal ones, which new vertex is farther left, or up.
fn first_is_shorter(vertices: &[Vertex], first: [Corner; 2], second: [Corner; 2]) -> bool {
    let ends = [first, second].map(|diagonal| diagonal.map(|corner| vertices[corner.0 as usize].drawn));
    let squared = ends.map(|[p, q]| {
        let (x, y) = (p[0] - q[0], p[1] - q[1]);
        x * x + y * y
    });
    let (m, n) = (ends[0][0], ends[1][1]);
    squared[0] < squared[1] || (squared[0] == squared[1] && (m[0] < n[0] || (m[0] == n[0] && m[1] <= n[1])))
}

#[cfg(test)]
mod tests;
