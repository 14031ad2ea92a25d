//! From poses and a refined mesh to what the rasteriser takes.

use super::distort::{Triangle, Vertex};
use super::path::Path;
use super::raster::Clip;
use super::refine::Refined;
use crate::blur::mesh::Mesh;
use crate::blur::motion::Segment;
use crate::view::Camera;

/// Pixel clip coordinates of each corner of each triangle of the mesh in a frame: v = R (p - eye), W = v.z,
/// X = f v.x + W width / 2, Y = W height / 2 - f v.y, f = height / 2 / tan(fov / 2).
pub fn corners(mesh: &Mesh, positions: &[[f32; 3]], camera: &Camera, size: [u32; 2]) -> Vec<[Clip; 3]> {
    let [width, height] = size.map(f64::from);
    let focal = height / 2.0 / (camera.vertical_fov.to_radians() / 2.0).tan();
    let rotation = camera.rotation();
    let clip = |point: &u32| {
        let p = positions[*point as usize].map(f64::from);
        let v = rotation * (glam::DVec3::from_array(p) - camera.eye);
        [focal * v.x + v.z * width / 2.0, v.z * height / 2.0 - focal * v.y, v.z]
    };
    mesh.triangles().iter().map(|triangle| triangle.each_ref().map(clip)).collect()
}

/// World normals of each corner of each triangle in a frame, of any length: the sum of the cross products of the sides of
/// the triangles in the corner's normal group, so that larger triangles count for more.
pub fn normals(mesh: &Mesh, positions: &[[f32; 3]]) -> Vec<[[f64; 3]; 3]> {
    let at = |point: u32| glam::DVec3::from_array(positions[point as usize].map(f64::from));
    let face = |triangle: &u32| {
        let [a, b, c] = mesh.triangles()[*triangle as usize].map(at);
        (b - a).cross(c - a)
    };
    let of_group = |group: &u32| -> [f64; 3] {
        mesh.group_triangles().of(*group as usize).iter().map(face).sum::<glam::DVec3>().to_array()
    };
    mesh.normal_groups().iter().map(|groups| groups.each_ref().map(of_group)).collect()
}

/// The refined triangles, each corner where its own time puts it. `segments` and `on_screen` are those of the interval.
pub fn triangles(refined: &Refined, segments: &[Segment], on_screen: bool) -> Vec<Triangle> {
    let triangle = |triangle: &super::refine::Triangle| {
        let corner = |i: usize| {
            let vertex = &refined.vertices[triangle.corners[i] as usize];
            let time = vertex.extent.time;
            let depth = f64::from(Path { segments, pieces: &vertex.pieces, on_screen }.at(time).depth);
            let [x, y] = vertex.drawn.map(f64::from);
            Vertex {
                drawn: [x * depth, y * depth, depth],
                time: time.into(),
                weights: triangle.weights[i].map(f64::from),
            }
        };
        Triangle { corners: [0, 1, 2].map(corner), base: triangle.base }
    };
    refined.triangles.iter().map(triangle).collect()
}

/// Whether each triangle's object is closed.
pub fn closed(mesh: &Mesh) -> Vec<bool> {
    let is_closed = |id: &u32| mesh.objects().iter().any(|object| object.id == *id && object.closed);
    mesh.triangle_objects().iter().map(is_closed).collect()
}

/// Whether each triangle stays where it is in frame i + 1: its points have label 0.
pub fn still(mesh: &Mesh, labels: &[u32]) -> Vec<bool> {
    mesh.triangles().iter().map(|triangle| triangle.iter().all(|point| labels[*point as usize] == 0)).collect()
}

#[cfg(test)]
mod tests;
