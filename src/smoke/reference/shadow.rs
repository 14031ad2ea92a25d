//! Shadows of spheres on spheres in closed form (section 3.2 of the paper has a shadow map instead).

use glam::DVec3;

use super::render::{Hit, Scene};
use crate::view::{LightSource, View};

/// Share of the light that reaches each pixel: 1 lit, 0 in shadow, 1 where nothing is seen. Pixels that face away from
/// the light have theirs, too.
///
/// 0 where the ray to the light (as far as a point light) meets the ball of any sphere but the pixel's own.
/// With `softness` k > 0 the rest is the least `(distance beside the ball) / (k t)` of all that the ray passes, t being
/// the way to the closest approach. `hits` are those of [`super::render::raycast`] for the same arguments.
pub fn shadow(
    view: &View,
    size: [u32; 2],
    spheres: &[[f64; 4]],
    hits: &[Option<Hit>],
    source: LightSource,
    softness: f64,
) -> Vec<f64> {
    let scene = Scene::new(view, size, spheres);
    let mut casters: Vec<Option<Vec<(DVec3, f64)>>> = vec![None; spheres.len()];
    let mut image = vec![1.0; hits.len()];
    for (pixel, own, point) in scene.seen(hits) {
        let Some(known) = casters.get_mut(own) else { continue };
        let casters = known.get_or_insert_with(|| casters_on(&scene, own, source, softness));
        let (direction, length) = scene.towards(source, point);
        let share = |(centre, radius): &(DVec3, f64)| reaches(*centre - point, *radius, direction, length, softness);
        image[pixel] = casters.iter().map(share).fold(1.0, f64::min);
    }
    image
}

/// Share of the light that one ball lets through, `centre` as seen from the point that is lit.
fn reaches(centre: DVec3, radius: f64, direction: DVec3, length: f64, softness: f64) -> f64 {
    let along = centre.dot(direction);
    let nearest = (centre - direction * along.clamp(0.0, length)).length();
    if nearest <= radius {
        return 0.0;
    }
    if softness > 0.0 && along > 0.0 && along < length {
        return ((nearest - radius) / (softness * along)).clamp(0.0, 1.0);
    }
    1.0
}

/// The spheres that can shadow any point of sphere `own`, never too few. A point's ray to the light stays within the
/// sphere's radius of the ray from its centre, and no closest approach is farther than the other centre.
fn casters_on(scene: &Scene, own: usize, source: LightSource, softness: f64) -> Vec<(DVec3, f64)> {
    let Some(Some((middle, reach))) = scene.spheres.get(own).copied() else { return Vec::new() };
    let (direction, length) = scene.towards(source, middle);
    let can = |(centre, radius): (DVec3, f64)| {
        let way = centre - middle;
        let nearest = (way - direction * way.dot(direction).clamp(0.0, length)).length();
        // A billionth more covers rounding.
        nearest <= (reach + radius + softness * (way.length() + reach)) * (1.0 + 1e-9)
    };
    let others = scene.spheres.iter().enumerate().filter(|(place, _)| *place != own);
    others.filter_map(|(_, sphere)| sphere.filter(|sphere| can(*sphere))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit};
    use crate::smoke::reference::render::raycast;
    use crate::view::Camera;

    fn camera() -> Camera {
        Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, ..Camera::default() }
    }

    /// Shadow in the middle of the picture, where a sphere of radius 1 is hit at (0, 0, -9), by one more sphere.
    fn middle(caster: [f64; 4], source: LightSource, softness: f64) -> f64 {
        let spheres = [[0.0, 0.0, -10.0, 1.0], caster];
        let hits = raycast(&camera().view([3, 3]), [3, 3], &spheres);
        assert_eq!(hits[4], Some(Hit { sphere: 0, depth: 9.0 }));
        shadow(&camera().view([3, 3]), [3, 3], &spheres, &hits, source, softness)[4]
    }

    #[test]
    fn a_directional_light_is_blocked_by_what_its_ray_meets() {
        // Light from above: the ray goes from (0, 0, -9) along +y.
        let light = LightSource::Direction(DVec3::new(0.0, -2.0, 0.0));
        assert_eq!(middle([0.0, 5.0, -9.0, 1.0], light, 0.0), 0.0);
        assert_eq!(middle([0.75, 5.0, -9.0, 1.0], light, 0.0), 0.0);
        assert_eq!(middle([1.25, 5.0, -9.0, 1.0], light, 0.0), 1.0);
        assert_eq!(middle([0.0, -5.0, -9.0, 1.0], light, 0.0), 1.0);
        assert_eq!(middle([0.0, 5.0, -9.0, 0.0], light, 0.0), 1.0);
    }

    #[test]
    fn a_point_light_is_blocked_only_by_what_is_before_it() {
        let light = LightSource::Position(DVec3::new(0.0, 5.0, -9.0));
        assert_eq!(middle([0.0, 3.0, -9.0, 1.0], light, 0.0), 0.0);
        assert_eq!(middle([0.0, 7.0, -9.0, 1.0], light, 0.0), 1.0);
        assert_eq!(middle([0.0, 5.5, -9.0, 1.0], light, 0.0), 0.0, "the light is inside");
    }

    #[test]
    fn softness_is_the_gap_over_the_way() {
        let light = LightSource::Direction(DVec3::new(0.0, -2.0, 0.0));
        // A gap of 0.25 after 5 m: an angle of 0.05.
        assert_eq!(middle([1.25, 5.0, -9.0, 1.0], light, 0.1), 0.5);
        assert_eq!(middle([1.25, 5.0, -9.0, 1.0], light, 0.05), 1.0);
        assert_eq!(middle([0.75, 5.0, -9.0, 1.0], light, 0.1), 0.0);
        assert_eq!(middle([1.25, -5.0, -9.0, 1.0], light, 0.1), 1.0, "behind the point");
        let point = LightSource::Position(DVec3::new(0.0, 5.5, -9.0));
        assert_eq!(middle([1.25, 5.0, -9.0, 1.0], point, 0.1), 0.5);
        assert_eq!(middle([1.25, 6.0, -9.0, 1.0], point, 0.1), 1.0, "beyond the light");
    }

    #[test]
    fn choosing_casters_changes_nothing() {
        let random = |i, d, scale: f64| (f64::from(unit(hash(8, i, 0, d))) - 0.5) * scale;
        let sphere = |i| [random(i, 0, 4.0), random(i, 1, 4.0), -5.0 + random(i, 2, 4.0), random(i, 3, 0.6) + 0.5];
        let spheres: Vec<[f64; 4]> = (0..60).map(sphere).collect();
        let (camera, size) = (Camera { vertical_fov: 50.0, ..camera() }, [32, 32]);
        let hits = raycast(&camera.view(size), size, &spheres);
        let sources =
            [LightSource::Direction(DVec3::new(-1.0, -1.0, -0.5)), LightSource::Position(DVec3::new(1.0, 1.0, -4.0))];
        for (source, softness) in sources.into_iter().flat_map(|source| [(source, 0.0), (source, 0.3)]) {
            let image = shadow(&camera.view(size), size, &spheres, &hits, source, softness);
            let scene = Scene::new(&camera.view(size), size, &spheres);
            for (pixel, own, point) in scene.seen(&hits) {
                let (direction, length) = scene.towards(source, point);
                let others = scene.spheres.iter().enumerate().filter(|(place, _)| *place != own);
                let expected = others.filter_map(|(_, sphere)| *sphere).fold(1.0, |least: f64, (centre, radius)| {
                    least.min(reaches(centre - point, radius, direction, length, softness))
                });
                assert_eq!(image[pixel], expected, "pixel {pixel}, {source:?}, softness {softness}");
            }
            let dark = image.iter().filter(|s| **s == 0.0).count();
            let between = image.iter().filter(|s| **s > 0.0 && **s < 1.0).count();
            assert!(dark > 50 && dark < 900 && (between > 50) == (softness > 0.0), "{dark} dark, {between} between");
        }
    }
}
