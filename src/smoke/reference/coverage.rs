//! Shares of pixels that smoke covers: antialiased silhouettes, in closed form.

use glam::DVec3;

use super::render::{Hit, Scene};
use super::tone::{inside, place};
use crate::view::View;

/// What a pixel has of the smoke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage {
    /// Share of it that smoke covers.
    pub share: f64,
    /// The pixel whose colour it has: its own, or one beside it where its middle sees no smoke.
    pub source: usize,
}

/// Coverage of every pixel. Where it and all beside it, also across corners, see smoke, it is 1. Else the greatest over
/// the spheres that they see of `clamp(1/2 - d, 0, 1)`, with d the distance in pixels from the pixel's middle to the
/// sphere's outline, below 0 inside: to first order, (q - r) / |grad q|, with q the distance of the ray from the centre.
/// What is cut open by the near plane has no outline there.
pub fn coverage(view: &View, size: [u32; 2], spheres: &[[f64; 4]], hits: &[Option<Hit>]) -> Vec<Coverage> {
    let scene = Scene::new(view, size, spheres);
    let of = |pixel: usize| {
        let [x, y] = place(size, pixel);
        let around = (0..9).filter_map(|i| inside(size, x + i % 3 - 1, y + i / 3 - 1));
        let is_seen = hits[pixel].is_some();
        let mut coverage = Coverage { share: if is_seen { 0.5 } else { 0.0 }, source: pixel };
        if around.clone().all(|beside| hits[beside].is_some()) {
            return Coverage { share: 1.0, source: pixel };
        }
        for beside in around {
            let Some(sphere) = hits[beside].and_then(|hit| scene.spheres[hit.sphere]) else { continue };
            let share = (0.5 - distance(&scene, [x, y], sphere)).clamp(0.0, 1.0);
            if share > coverage.share && (is_seen || share <= 0.5) {
                coverage = Coverage { share, source: if is_seen { pixel } else { beside } };
            }
        }
        coverage
    };
    (0..hits.len()).map(of).collect()
}

/// Distance in pixels from the middle of a pixel to the outline of a sphere, to first order; the gradient by differences.
fn distance(scene: &Scene, [x, y]: [i64; 2], (centre, radius): (DVec3, f64)) -> f64 {
    let away = |dx: f64, dy: f64| {
        let [from, way] = scene.ray_at(x as f64 + 0.5 + dx, y as f64 + 0.5 + dy);
        (centre - from).cross(way.normalize()).length()
    };
    let step = 1e-4;
    let [across, down] = [[step, 0.0], [0.0, step]].map(|[a, b]| (away(a, b) - away(-a, -b)) / (2.0 * step));
    (away(0.0, 0.0) - radius) / across.hypot(down)
}

/// A picture whose pixels have their share of what they show.
pub fn covered(image: &[[f64; 4]], coverage: &[Coverage]) -> Vec<[f64; 4]> {
    coverage.iter().map(|Coverage { share, source }| image[*source].map(|c| share * c)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoke::reference::render::raycast;
    use crate::view::Camera;

    const SIZE: [u32; 2] = [40, 30];

    /// Shares of pixels by many rays each.
    fn counted(view: &View, spheres: &[[f64; 4]]) -> Vec<f64> {
        const FINE: u32 = 24;
        let hits = raycast(view, SIZE.map(|n| n * FINE), spheres);
        let wide = (SIZE[0] * FINE) as usize;
        let mut shares = vec![0.0; (SIZE[0] * SIZE[1]) as usize];
        for (i, _) in hits.iter().enumerate().filter(|(_, hit)| hit.is_some()) {
            let (x, y) = (i % wide / FINE as usize, i / wide / FINE as usize);
            shares[y * SIZE[0] as usize + x] += 1.0 / f64::from(FINE * FINE);
        }
        shares
    }

    #[test]
    fn coverage_is_the_share_that_rays_count() {
        let camera = Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 60.0, ..Camera::default() };
        let view = camera.view(SIZE);
        for (name, spheres) in [
            ("one", vec![[0.1, 0.05, -4.0, 1.0]]),
            ("beside the middle", vec![[2.0, 1.2, -4.0, 0.8]]),
            ("two apart", vec![[-1.0, 0.0, -4.0, 0.6], [1.0, 0.3, -6.0, 0.9]]),
        ] {
            let hits = raycast(&view, SIZE, &spheres);
            let (shares, counted) = (coverage(&view, SIZE, &spheres, &hits), counted(&view, &spheres));
            let apart = shares.iter().zip(&counted).map(|(a, b)| (a.share - b).abs());
            // A straight border of slope 1 that cuts off a corner: 1/2 - d stands for a parabola, at most 0.06 apart; and
            // discs of five pixels and more are nearly straight in a pixel.
            assert!(apart.clone().fold(0.0, f64::max) < 0.1, "{name}");
            let all: [f64; 2] = [shares.iter().map(|c| c.share).sum(), counted.iter().sum()];
            // Of a disc of five pixels and more; half of its curvature goes unseen in each pixel of its border.
            assert!((all[0] - all[1]).abs() < 0.006 * all[1], "{name}: {all:?}");
        }
    }

    #[test]
    fn what_is_beside_smoke_has_its_colour() {
        let camera = Camera { eye: DVec3::ZERO, target: -DVec3::Z, ..Camera::default() };
        let view = camera.view(SIZE);
        let spheres = [[0.0, 0.0, -4.0, 0.7]];
        let hits = raycast(&view, SIZE, &spheres);
        let all = coverage(&view, SIZE, &spheres, &hits);
        let image: Vec<[f64; 4]> =
            hits.iter().map(|hit| if hit.is_some() { [0.5, 0.25, 1.0, 1.0] } else { [0.0; 4] }).collect();
        let covered = covered(&image, &all);
        let mut beside = 0;
        for (i, (colour, hit)) in covered.iter().zip(&hits).enumerate() {
            assert_eq!(colour[3], all[i].share);
            assert_eq!(*colour, [0.5, 0.25, 1.0, 1.0].map(|c| c * colour[3]));
            assert!(if hit.is_some() { colour[3] >= 0.5 } else { colour[3] <= 0.5 });
            beside += u32::from(hit.is_none() && colour[3] > 0.0);
        }
        assert!(beside > 10, "{beside} pixels beside it");
    }
}
