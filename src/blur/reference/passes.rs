//! The passes that a renderer would write of a mesh: what a pixel's centre sees, where it was and where it will be.

use super::raster::{Clip, Shape, raster};
use crate::io::passes::PassFrame;

/// Places of the points of a mesh in pixel clip coordinates: in the frame before, in the frame, in the one after.
#[derive(Clone, Copy, Debug)]
pub struct Moments<'a> {
    /// In the frame before.
    pub before: &'a [Clip],
    /// In the frame that is seen.
    pub now: &'a [Clip],
    /// In the frame after.
    pub after: &'a [Clip],
}

/// What passes of `size` pixels say of a mesh, whose triangles are of these objects, and the triangle that each pixel sees, from 1;
/// 0: none. Nothing nearer than `near` metres is seen.
pub fn passes(
    triangles: &[[u32; 3]],
    objects: &[u32],
    moments: Moments,
    size: [u32; 2],
    near: f64,
) -> (PassFrame, Vec<u32>) {
    let Moments { before, now, after } = moments;
    let corners = |of: &[Clip], triangle: u32| triangles[triangle as usize].map(|point| of[point as usize]);
    let shapes: Vec<Option<Shape>> = (0..triangles.len() as u32).map(|i| Shape::new(corners(now, i))).collect();
    let seen = raster(&shapes, size, near);
    let mut frame = PassFrame {
        size,
        depth: seen.depth.iter().map(|depth| *depth as f32).collect(),
        id: vec![0; seen.seen.len()],
        previous: vec![[0.0; 2]; seen.seen.len()],
        next: None,
    };
    let mut next = vec![[0.0; 2]; seen.seen.len()];
    for (pixel, name) in seen.seen.iter().enumerate() {
        let Some(triangle) = name.checked_sub(1) else { continue };
        let Some(shape) = &shapes[triangle as usize] else { continue };
        let width = size[0] as usize;
        let at = [(pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5];
        let weights = shape.plane_weights(at);
        let vector = |of: &[Clip]| {
            let corners = corners(of, triangle);
            let [x, y, w] = [0, 1, 2].map(|c| (0..3).map(|i| weights[i] * corners[i][c]).sum::<f64>());
            [x / w - at[0], y / w - at[1]].map(|c| c as f32)
        };
        frame.id[pixel] = objects[triangle as usize];
        frame.previous[pixel] = vector(before);
        next[pixel] = vector(after);
    }
    frame.next = Some(next);
    (frame, seen.seen)
}
