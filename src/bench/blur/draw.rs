//! Frames to be blurred: a mesh in two flat tones, whose colours depend on nothing but material and normal. So they are
//! known, too, where something else hides the surface.

use glam::{DMat3, DVec3};

use crate::blur::motion::PixelClip;
use crate::data::Topology;
use crate::view::View;

/// Where the light comes from.
pub(super) const LIGHT: DVec3 = DVec3::new(0.5, 0.7, 0.6);
/// Cosine of the angle to the light beyond which it is dark.
const SHADE: f64 = 0.25;
/// Factors of red, green and blue in the dark.
const DARK: [f32; 3] = [0.35, 0.40, 0.60];

/// Linear RGB of each pixel, premultiplied, rows from the top; empty where nothing is. `positions` is the world position
/// of each vertex, and `light` points to where it comes from.
pub(super) fn picture(
    topology: &Topology,
    positions: &[[f32; 3]],
    view: &View,
    light: DVec3,
    size: [u32; 2],
) -> Vec<[f32; 4]> {
    let [width, height] = size.map(|side| side as usize);
    let mut pixels = vec![[0.0; 4]; width * height];
    let mut nearest = vec![f64::INFINITY; width * height];
    let normals = normals(topology, positions);
    let projection = PixelClip::new(view, view.jitter, size);
    for corners in &topology.triangles {
        let [a, b, c] = corners.map(|corner| projection.clip(positions[corner as usize]));
        if a.z.min(b.z).min(c.z) <= projection.near {
            continue;
        }
        // Barycentrics over the depth of a pixel (x, y, 1).
        let matrix = DMat3::from_cols(a, b, c);
        if matrix.determinant() == 0.0 {
            continue;
        }
        let barycentrics_of = matrix.inverse();
        let range = |axis: usize, side: usize| {
            let ends = [a, b, c].map(|p| p[axis] / p.z);
            let low = ends.iter().copied().fold(f64::INFINITY, f64::min).floor().clamp(0.0, side as f64);
            let high = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max).ceil().clamp(0.0, side as f64);
            low as usize..high as usize
        };
        for y in range(1, height) {
            for x in range(0, width) {
                let barycentrics = barycentrics_of * DVec3::new(x as f64 + 0.5, y as f64 + 0.5, 1.0);
                let depth = barycentrics.element_sum().recip();
                let pixel = y * width + x;
                if barycentrics.min_element() < 0.0 || depth >= nearest[pixel] {
                    continue;
                }
                nearest[pixel] = depth;
                let normal: DVec3 = (0..3).map(|i| barycentrics[i] * normals[corners[i] as usize]).sum();
                pixels[pixel] = colour(topology.colour[corners[0] as usize], normal, light);
            }
        }
    }
    pixels
}

fn colour(of: [f32; 3], normal: DVec3, light: DVec3) -> [f32; 4] {
    let is_lit = normal.normalize_or_zero().dot(light.normalize_or_zero()) > SHADE;
    let [r, g, b] = [0, 1, 2].map(|i| if is_lit { of[i] } else { of[i] * DARK[i] });
    [r, g, b, 1.0]
}

/// The mean of the normals of a vertex's triangles by their areas. Vertices at hard edges are double.
fn normals(topology: &Topology, positions: &[[f32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for corners in &topology.triangles {
        let [a, b, c] = corners.map(|corner| DVec3::from(positions[corner as usize].map(f64::from)));
        let area = (b - a).cross(c - a);
        corners.iter().for_each(|corner| normals[*corner as usize] += area);
    }
    normals.iter().map(|normal| normal.normalize_or_zero()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Camera;

    #[test]
    fn the_nearer_triangle_is_seen_and_what_turns_from_the_light_is_dark() {
        // A large red triangle at z = 0 and a small green one before its lower half, which looks down.
        let topology = Topology {
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            object: vec![0, 0, 0, 1, 1, 1],
            colour: [[[1.0, 0.0, 0.0]; 3], [[0.0, 1.0, 0.0]; 3]].concat(),
            ..Topology::default()
        };
        let positions =
            [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 30.0, 0.0], [-0.5, 0.4, 0.1], [0.5, 0.4, 0.1], [0.0, 0.9, 1.5]];
        let pixels = picture(&topology, &positions, &Camera::default().view([64, 64]), LIGHT, [64, 64]);
        assert_eq!(pixels[10 * 64 + 32], [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(pixels[36 * 64 + 32], [0.0, DARK[1], 0.0, 1.0]);
        let rear = picture(&topology.without(1), &positions, &Camera::default().view([64, 64]), LIGHT, [64, 64]);
        assert_eq!(rear[36 * 64 + 32], [1.0, 0.0, 0.0, 1.0]);
    }
}
