//! From poses and a refined mesh to what the rasteriser takes.

use std::collections::HashMap;

use glam::DVec3;

use super::distort::{Outside, Triangle, Vertex};
use super::path::Path;
use super::raster::Clip;
use super::refine::Refined;
use crate::blur::mesh::Mesh;
use crate::blur::motion::Segment;
use crate::view::{Projection, View};

/// Pixel clip coordinates of each corner of each triangle of the mesh in a frame, straight from the view's matrices: of clip coordinates
/// (x, y, z, w), X = (x + w) width / 2 and Y = (y + w) height / 2, moved by the jitter, and W = w, all over what w grows by with a metre.
pub fn corners(mesh: &Mesh, positions: &[[f32; 3]], view: &View, size: [u32; 2]) -> Vec<[Clip; 3]> {
    let [width, height] = size.map(f64::from);
    let matrix = view.view_to_clip * view.world_to_view;
    let metre = view.view_to_clip.row(3).truncate().length();
    let clip = |point: &u32| {
        let p = positions[*point as usize].map(f64::from);
        let [x, y, _, w] = (matrix * DVec3::from_array(p).extend(1.0) / metre).to_array();
        [(x + w) * width / 2.0 + view.jitter[0] * w, (y + w) * height / 2.0 + view.jitter[1] * w, w]
    };
    mesh.triangles().iter().map(|triangle| triangle.each_ref().map(clip)).collect()
}

/// World normals of each corner of each triangle in a frame, of any length: the sum of the cross products of the sides of
/// the triangles in the corner's normal group, so that larger triangles count for more. To the outside, where there is one.
pub fn normals(mesh: &Mesh, positions: &[[f32; 3]], outsides: &[Outside]) -> Vec<[[f64; 3]; 3]> {
    let at = |point: u32| DVec3::from_array(positions[point as usize].map(f64::from));
    let face = |triangle: &u32| {
        let [a, b, c] = mesh.triangles()[*triangle as usize].map(at);
        (b - a).cross(c - a)
    };
    let of_group = |group: &u32| mesh.group_triangles().of(*group as usize).iter().map(face).sum::<DVec3>();
    let side = |outside: &Outside| if *outside == Outside::Clockwise { -1.0 } else { 1.0 };
    let corners = mesh.normal_groups().iter().zip(outsides);
    corners
        .map(|(groups, outside)| groups.each_ref().map(|group| (side(outside) * of_group(group)).to_array()))
        .collect()
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

/// The outside of each triangle of the mesh in a frame, as seen through `view` in pictures of `size` pixels. Closed is what
/// hangs together over edges, each of which one triangle runs along in either direction. It is flat if its volume is less
/// than what moving its area by 2^-20 of its largest coordinate makes, and may hold the eye if this is in its box, or farther
/// away along no axis than the near plane's width, height and distance together, halved but for the distance.
pub fn outsides(mesh: &Mesh, positions: &[[f32; 3]], view: &View, size: [u32; 2]) -> Vec<Outside> {
    let at = |point: u32| DVec3::from_array(positions[point as usize].map(f64::from));
    let Projection { eye, near, .. } = Projection::of_valid(view, size);
    let [low, high] = Projection::of_valid(view, size).borders(size);
    let reach = near + near * low.abs().max(high.abs()).element_sum();
    let outside = |surface: &Vec<usize>| {
        let corners: Vec<[DVec3; 3]> = surface.iter().map(|t| mesh.triangles()[*t].map(at)).collect();
        let all = || corners.iter().flatten().copied();
        let low = all().fold(DVec3::INFINITY, DVec3::min);
        let high = all().fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle = (low + high) / 2.0;
        let volume: f64 = corners.iter().map(|[a, b, c]| (a - middle).dot((b - middle).cross(c - middle)) / 6.0).sum();
        let spread = |normal: DVec3| normal.abs().element_sum() / 2.0;
        let area: f64 = corners.iter().map(|[a, b, c]| spread((b - a).cross(c - a))).sum();
        let farthest = low.abs().max(high.abs()).max_element();
        let is_flat = volume.abs() <= area * farthest * 0.5_f64.powi(20) / 6.0;
        let holds = eye.clamp(low - reach, high + reach) == eye;
        match (is_flat || holds, volume > 0.0) {
            (true, _) => Outside::None,
            (false, true) => Outside::CounterClockwise,
            (false, false) => Outside::Clockwise,
        }
    };
    let mut outsides = vec![Outside::None; mesh.triangles().len()];
    for surface in closed_surfaces(mesh) {
        let outside = outside(&surface);
        surface.iter().for_each(|triangle| outsides[*triangle] = outside);
    }
    outsides
}

/// The triangles of each closed surface.
fn closed_surfaces(mesh: &Mesh) -> Vec<Vec<usize>> {
    let sides = |triangle: &[u32; 3]| [0, 1, 2].map(|i| (triangle[i], triangle[(i + 1) % 3]));
    let mut at_side: HashMap<(u32, u32), Vec<usize>> = HashMap::new();
    let has_area = |triangle: &[u32; 3]| sides(triangle).iter().all(|(a, b)| a != b);
    for (number, triangle) in mesh.triangles().iter().enumerate().filter(|(_, triangle)| has_area(triangle)) {
        sides(triangle).iter().for_each(|side| at_side.entry(*side).or_default().push(number));
    }
    let along = |side: (u32, u32)| at_side.get(&side).map_or(&[][..], |triangles| &triangles[..]);
    // The one beyond a side, if the edge is one of exactly two.
    let beyond = |(a, b): (u32, u32)| match (along((a, b)), along((b, a))) {
        ([_], [other]) => Some(*other),
        _ => None,
    };
    let mut is_left: Vec<bool> = mesh.triangles().iter().map(has_area).collect();
    let mut surfaces = Vec::new();
    for first in 0..is_left.len() {
        let (mut surface, mut waiting, mut is_closed) = (Vec::new(), vec![first], true);
        while let Some(triangle) = waiting.pop() {
            if std::mem::take(&mut is_left[triangle]) {
                surface.push(triangle);
                let others = sides(&mesh.triangles()[triangle]).map(beyond);
                is_closed &= others.iter().all(Option::is_some);
                waiting.extend(others.into_iter().flatten());
            }
        }
        surfaces.extend((is_closed && !surface.is_empty()).then_some(surface));
    }
    surfaces
}

/// Whether each triangle has an outside in frame i and in frame i + 1.
pub fn closed(outsides: [&[Outside]; 2]) -> Vec<bool> {
    let [previous, next] = outsides;
    previous.iter().zip(next).map(|(a, b)| *a != Outside::None && *b != Outside::None).collect()
}

/// Whether each triangle stays where it is in frame i + 1: its points have label 0.
pub fn still(mesh: &Mesh, labels: &[u32]) -> Vec<bool> {
    mesh.triangles().iter().map(|triangle| triangle.iter().all(|point| labels[*point as usize] == 0)).collect()
}

#[cfg(test)]
mod tests;
