//! The distorted mesh: what each sample sees of it, at which sub-frame time, and where that is in any frame.

use super::raster::{Clip, Raster, Shape, raster, volume};

/// From which side a triangle is seen that is of a closed surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// From both: it is of none, or of a flat one, or of one that may hold the eye.
    None,
    /// From where its corners follow each other counter-clockwise.
    CounterClockwise,
    /// From where they do so clockwise.
    Clockwise,
}

/// A corner of a triangle of the refined mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where it is at its own sub-frame time.
    pub drawn: Clip,
    /// That time, k', in frames after frame i.
    pub time: f64,
    /// Its barycentric coordinates in the mesh's triangle.
    pub weights: [f64; 3],
}

/// A triangle of the refined mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Its corners.
    pub corners: [Vertex; 3],
    /// The mesh's triangle that it is a part of.
    pub base: u32,
}

/// The surface that a sample sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// The refined triangle, from 0.
    pub triangle: u32,
    /// The mesh's triangle.
    pub base: u32,
    /// k' there.
    pub time: f64,
    /// W there at that time in metres.
    pub depth: f64,
    /// Barycentric coordinates of the place in the mesh's triangle: with these, it is known in each frame.
    pub weights: [f64; 3],
}

/// The distorted mesh, drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// The triangle that each sample sees. Its size is that of the picture times `samples`.
    pub raster: Raster,
    /// The same with what is interpolated.
    pub fragments: Vec<Option<Fragment>>,
    /// Samples along a pixel's side.
    pub samples: u32,
}

/// Interpolation of three corners' values at barycentric coordinates.
pub fn interpolate<const N: usize>(weights: [f64; 3], values: [[f64; N]; 3]) -> [f64; N] {
    std::array::from_fn(|i| weights[0] * values[0][i] + weights[1] * values[1][i] + weights[2] * values[2][i])
}

/// Whether each of the mesh's triangles is not drawn: those whose outside is turned away in frame i and in frame i + 1. The
/// corners are those in each of the two frames.
pub fn hidden(corners: [&[[Clip; 3]]; 2], outsides: [&[Outside]; 2]) -> Vec<bool> {
    let is_away = |frame: usize, triangle: usize| {
        let volume = volume(corners[frame][triangle]);
        match outsides[frame][triangle] {
            Outside::None => false,
            Outside::CounterClockwise => volume > 0.0,
            Outside::Clockwise => volume < 0.0,
        }
    };
    (0..corners[0].len()).map(|triangle| is_away(0, triangle) && is_away(1, triangle)).collect()
}

/// Draws the refined mesh at the centres of `samples` x `samples` parts of each pixel of a picture of `size` pixels.
/// `hidden` speaks of the mesh's triangles.
pub fn draw(triangles: &[Triangle], hidden: &[bool], size: [u32; 2], near: f64, samples: u32) -> Drawing {
    let fine = f64::from(samples);
    let shape = |triangle: &Triangle| {
        let corners = triangle.corners.map(|Vertex { drawn: [x, y, w], .. }| [x * fine, y * fine, w]);
        if hidden[triangle.base as usize] { None } else { Shape::new(corners) }
    };
    let shapes: Vec<Option<Shape>> = triangles.iter().map(shape).collect();
    let raster = raster(&shapes, size.map(|side| side * samples), near);
    let width = raster.size[0] as usize;
    let fragment = |(place, (name, depth)): (usize, (&u32, &f64))| {
        let triangle = name.checked_sub(1)?;
        let at = [(place % width) as f64 + 0.5, (place / width) as f64 + 0.5];
        let weights = shapes[triangle as usize].as_ref()?.weights(at)?;
        let Triangle { corners, base } = triangles[triangle as usize];
        let [time] = interpolate(weights, corners.map(|corner| [corner.time]));
        let weights = interpolate(weights, corners.map(|corner| corner.weights));
        Some(Fragment { triangle, base, time, depth: *depth, weights })
    };
    let fragments = raster.seen.iter().zip(&raster.depth).enumerate().map(fragment).collect();
    Drawing { fragments, raster, samples }
}

#[cfg(test)]
mod tests;
