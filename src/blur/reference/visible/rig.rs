//! A mesh of squares that face the camera, for tests.

use super::{Frame, Surface};
use crate::blur::reference::distort::{Drawing, Triangle, Vertex, draw};
use crate::blur::reference::raster::Clip;

pub const SIZE: [u32; 2] = [24, 8];
pub const NEAR: f64 = 0.1;

/// A square: two triangles.
#[derive(Clone, Copy)]
pub struct Square {
    /// Left, upper, right and lower border in pixels in frames i and i + 1.
    pub boxes: [[f64; 4]; 2],
    /// Depth at its left and its right border in both frames.
    pub depth: [f64; 2],
    pub object: u32,
    /// World normal in frames i and i + 1.
    pub normals: [[f64; 3]; 2],
    /// Its colour in the images of frames i and i + 1.
    pub colours: [[f32; 4]; 2],
    pub is_still: bool,
}

impl Square {
    pub fn new(object: u32, depth: f64, boxes: [[f64; 4]; 2], colours: [[f32; 4]; 2]) -> Square {
        let is_still = boxes[0] == boxes[1];
        Square { boxes, depth: [depth; 2], object, normals: [[0.0, 0.0, 1.0]; 2], colours, is_still }
    }
}

/// All of a test's mesh and images.
pub struct Rig {
    objects: Vec<u32>,
    closed: Vec<bool>,
    still: Vec<bool>,
    corners: [Vec<[Clip; 3]>; 2],
    normals: [Vec<[[f64; 3]; 3]>; 2],
    pub images: [Vec<[f32; 4]>; 2],
}

impl Rig {
    /// The images show the squares over `sky`.
    pub fn new(squares: &[Square], sky: [f32; 4]) -> Rig {
        let twice = || squares.iter().flat_map(|square| [square, square]);
        let corners = [0, 1].map(|k| squares.iter().flat_map(|square| halves(square, k)).collect());
        let mut rig = Rig {
            objects: twice().map(|square| square.object).collect(),
            closed: twice().map(|_| false).collect(),
            still: twice().map(|square| square.is_still).collect(),
            corners,
            normals: [0, 1].map(|k| twice().map(|square| [square.normals[k]; 3]).collect()),
            images: [Vec::new(), Vec::new()],
        };
        rig.images = [0, 1].map(|k| {
            let seen = rig.frame(k).seen.seen;
            let colour = |name: &u32| name.checked_sub(1).map_or(sky, |base| squares[base as usize / 2].colours[k]);
            seen.iter().map(colour).collect()
        });
        rig
    }

    pub fn surface(&self) -> Surface<'_> {
        Surface { surfaces: &self.objects, closed: &self.closed, still: &self.still, near: NEAR }
    }

    pub fn frame(&self, k: usize) -> Frame<'_> {
        Frame::new(&self.corners[k], &self.normals[k], &self.images[k], SIZE, NEAR)
    }

    /// The mesh at one sub-frame time; what stays at 1.
    pub fn draw(&self, time: f64, samples: u32) -> Drawing {
        let triangle = |base: usize| {
            let time = if self.still[base] { 1.0 } else { time };
            let vertex = |i: usize| {
                let [from, to] = [0, 1].map(|k| self.corners[k][base][i]);
                let drawn = [0, 1, 2].map(|c| from[c] + time * (to[c] - from[c]));
                Vertex { drawn, time, weights: [0, 1, 2].map(|c| f64::from(u8::from(c == i))) }
            };
            Triangle { corners: [0, 1, 2].map(vertex), base: base as u32 }
        };
        let triangles: Vec<Triangle> = (0..self.objects.len()).map(triangle).collect();
        draw(&triangles, &vec![false; triangles.len()], SIZE, NEAR, samples)
    }
}

fn halves(square: &Square, k: usize) -> [[Clip; 3]; 2] {
    let [left, top, right, bottom] = square.boxes[k];
    let [near, far] = square.depth;
    let at = |x: f64, y: f64, w: f64| [x * w, y * w, w];
    let [a, b, c, d] = [at(left, top, near), at(left, bottom, near), at(right, bottom, far), at(right, top, far)];
    [[a, b, c], [a, c, d]]
}
