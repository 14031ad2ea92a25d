//! Spheres as the camera sees them: the nearest front hit of every pixel, and its luminance (section 3.2 of the paper).

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::shaders::smoke::constants::{SHRUNK_AWAY, WAY_SAMPLES};
use crate::view::{FireLight, Light, LightSource, Projection, View};

/// The surface that a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Place of the sphere in the list.
    pub sphere: usize,
    /// Linear view depth of the hit in metres.
    pub depth: f64,
}

/// Picture and spheres in view space: x right, y up, z = depth. `spheres` are centre and radius in metres.
pub(super) struct Scene {
    projection: Projection,
    size: [u32; 2],
    /// Centre and radius; none where there is no sphere to see: radius 0, or not finite.
    pub(super) spheres: Vec<Option<(DVec3, f64)>>,
}

impl Scene {
    pub(super) fn new(view: &View, size: [u32; 2], spheres: &[[f64; 4]]) -> Scene {
        let projection = Projection::of_valid(view, size);
        let sphere = |s: &[f64; 4]| {
            let centre = projection.to_view(DVec3::new(s[0], s[1], s[2]));
            (s[3] > 0.0 && s[3].is_finite() && centre.is_finite()).then_some((centre, s[3]))
        };
        Scene { projection, size, spheres: spheres.iter().map(sphere).collect() }
    }

    /// The ray through the middle of pixel (x, y), y down: where it begins, and its direction with z = 1.
    fn ray(&self, x: u32, y: u32) -> [DVec3; 2] {
        self.ray_at(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    /// The ray through any place of the picture, in pixels.
    pub(super) fn ray_at(&self, x: f64, y: f64) -> [DVec3; 2] {
        self.projection.ray_at(DVec2::new(x, y))
    }

    /// Pixels that may see a sphere: columns and rows, never too few. The planes through the eye that touch the sphere
    /// bound it; where the sphere reaches behind the eye there are none, and it may be seen anywhere. Parallel rays touch it at its
    /// radius.
    fn bounds(&self, centre: DVec3, radius: f64) -> [Range<u32>; 2] {
        let Projection { focal, centre: middle_pixel, is_orthographic, .. } = self.projection;
        [0, 1].map(|axis| {
            let n = self.size[axis];
            let (across, z) = (centre[axis], centre.z);
            if !is_orthographic && z - radius <= 1e-9 * z.abs() {
                return 0..n;
            }
            let middle = across * z;
            let spread = radius * (across * across + (z - radius) * (z + radius)).sqrt();
            let slopes = [-1.0, 1.0].map(|side| match is_orthographic {
                true => across + side * radius,
                false => (middle + side * spread) / ((z - radius) * (z + radius)),
            });
            // Rows go down where y goes up. A pixel more on each side covers rounding.
            let [low, high] = if axis == 0 { slopes } else { [-slopes[1], -slopes[0]] };
            let pixel = |slope: f64| middle_pixel[axis] + focal[axis] * slope;
            let start = (pixel(low) - 2.0).clamp(0.0, f64::from(n)) as u32;
            let end = (pixel(high) + 2.0).ceil().clamp(0.0, f64::from(n)) as u32;
            start..end
        })
    }

    /// Every pixel that sees something: its place in the image, its sphere and the hit in view space.
    pub(super) fn seen<'b>(&'b self, hits: &'b [Option<Hit>]) -> impl Iterator<Item = (usize, usize, DVec3)> + 'b {
        hits.iter().enumerate().filter_map(|(pixel, hit)| {
            let hit = (*hit)?;
            let place = pixel as u32;
            let [from, way] = self.ray(place % self.size[0], place / self.size[0]);
            Some((pixel, hit.sphere, from + way * hit.depth))
        })
    }

    /// Unit vector from the view-space `point` towards the light, and the distance to it. Zero in the light itself.
    pub(super) fn towards(&self, source: LightSource, point: DVec3) -> (DVec3, f64) {
        match source {
            LightSource::Direction(direction) => {
                (-(self.projection.axes * direction).normalize_or_zero(), f64::INFINITY)
            }
            LightSource::Position(position) => {
                let way = self.projection.to_view(position) - point;
                (way.normalize_or_zero(), way.length())
            }
        }
    }
}

/// The spheres as they are drawn where those of a diameter below `smallest` pixels shrink by smoothstep, less the last
/// tenth, to nothing at half of it; 0: all are as they are.
pub fn drawn(view: &View, size: [u32; 2], smallest: f64, spheres: &[[f64; 4]]) -> Vec<[f64; 4]> {
    let projection = Projection::of_valid(view, size);
    let least = f64::from(SHRUNK_AWAY);
    let drawn = |[x, y, z, radius]: &[f64; 4]| {
        let depth = projection.to_view(DVec3::new(*x, *y, *z)).z.max(projection.near);
        let metres = if projection.is_orthographic { 1.0 } else { depth } / projection.focal.y;
        let t = if smallest > 0.0 { (4.0 * radius / metres / smallest - 1.0).clamp(0.0, 1.0) } else { 1.0 };
        let share = (t * t * (3.0 - 2.0 * t) - least) / (1.0 - least);
        [*x, *y, *z, radius * share.max(0.0)]
    };
    spheres.iter().map(drawn).collect()
}

/// Nearest front hit of every pixel with a depth in near..=far, row by row from the top; of equal ones the first sphere.
///
/// `size` in pixels; `spheres` are centre and radius in metres, radius 0 is none. A sphere that the camera is inside of
/// has no front to see.
pub fn raycast(view: &View, size: [u32; 2], spheres: &[[f64; 4]]) -> Vec<Option<Hit>> {
    let scene = Scene::new(view, size, spheres);
    let Projection { near, far, .. } = scene.projection;
    let mut hits: Vec<Option<Hit>> = vec![None; size[0] as usize * size[1] as usize];
    for (sphere, shape) in scene.spheres.iter().enumerate() {
        let Some((centre, radius)) = *shape else { continue };
        let [columns, rows] = scene.bounds(centre, radius);
        for y in rows {
            for x in columns.clone() {
                let depth = front(scene.ray(x, y), centre, radius);
                let Some(depth) = depth.filter(|z| (near..=far).contains(z)) else { continue };
                let seen = &mut hits[y as usize * size[0] as usize + x as usize];
                if seen.is_none_or(|other| depth < other.depth) {
                    *seen = Some(Hit { sphere, depth });
                }
            }
        }
    }
    hits
}

/// Where the line `from + t * way` enters the sphere: from its closest approach to the centre back by half the chord.
/// The form does not cancel for small spheres far away.
fn front([from, way]: [DVec3; 2], centre: DVec3, radius: f64) -> Option<f64> {
    let centre = centre - from;
    let squared = way.length_squared();
    let closest = way.dot(centre) / squared;
    let beside = (centre - way * closest).length_squared();
    let chord = radius * radius - beside;
    (chord >= 0.0).then(|| closest - (chord / squared).sqrt())
}

/// Luminance of every pixel without a rim, 0 to 1: `ambient + (1 - ambient) max(0, n.l) s`, with a share of it filled, and the
/// second light over that; 0 where nothing is seen.
///
/// `hits` are [`raycast`]'s, `shadow` is s of every pixel: 1 lit, 0 in shadow.
pub fn luminance(
    view: &View,
    size: [u32; 2],
    spheres: &[[f64; 4]],
    hits: &[Option<Hit>],
    light: &Light,
    shadow: &[f64],
) -> Vec<f64> {
    let scene = Scene::new(view, size, spheres);
    let mut image = vec![0.0; hits.len()];
    for (pixel, sphere, point) in scene.seen(hits) {
        let Some(Some((centre, radius))) = scene.spheres.get(sphere) else { continue };
        let normal = (point - centre) / *radius;
        let facing = normal.dot(scene.towards(light.source, point).0);
        let second = light.second.map_or(0.0, |second| normal.dot(scene.towards(second.source, point).0));
        let up = normal.dot(scene.projection.axes * light.up.normalize());
        image[pixel] = light.with_second(light.luminance(facing, shadow[pixel], up), second).clamp(0.0, 1.0);
    }
    image
}

/// How far what every pixel sees turns away from the light and from the eye, 0 to 1; 0 where nothing is seen.
pub fn turned_away(view: &View, size: [u32; 2], spheres: &[[f64; 4]], hits: &[Option<Hit>], light: &Light) -> Vec<f64> {
    let scene = Scene::new(view, size, spheres);
    let mut image = vec![0.0; hits.len()];
    for (pixel, sphere, point) in scene.seen(hits) {
        let Some(Some((centre, radius))) = scene.spheres.get(sphere) else { continue };
        let normal = (point - centre) / *radius;
        let eye = if scene.projection.is_orthographic { -DVec3::Z } else { -point.normalize() };
        let facing = normal.dot(scene.towards(light.source, point).0);
        image[pixel] = Light::turned_away(facing, normal.dot(eye));
    }
    image
}

/// The fire's light on every pixel, 0 to 1: `(1/2 + n.l/2) / (1 + (d/reach)^2)` by what of the way is free of smoke; 0 where
/// nothing is seen. `is_smoke` says whether a place in the world is in it.
pub fn fire(
    view: &View,
    size: [u32; 2],
    spheres: &[[f64; 4]],
    hits: &[Option<Hit>],
    fire: &FireLight,
    is_smoke: impl Fn(DVec3) -> bool,
) -> Vec<f64> {
    let scene = Scene::new(view, size, spheres);
    let Projection { axes, eye, .. } = scene.projection;
    let mut image = vec![0.0; hits.len()];
    for (pixel, sphere, point) in scene.seen(hits) {
        let Some(Some((centre, radius))) = scene.spheres.get(sphere) else { continue };
        let (towards, distance) = scene.towards(LightSource::Position(fire.position), point);
        let wrapped = 0.5 + 0.5 * ((point - centre) / *radius).dot(towards);
        let place = axes.transpose() * point + eye;
        let at = |i| place.lerp(fire.position, (f64::from(i) + 0.5) / f64::from(WAY_SAMPLES));
        let free = (0..WAY_SAMPLES).filter(|i| !is_smoke(at(*i))).count();
        image[pixel] = wrapped * fire.falloff(distance) * free as f64 / f64::from(WAY_SAMPLES);
    }
    image
}

/// Height of what every pixel sees above the world's origin in metres, along `up`; 0 where nothing is seen.
pub fn height(view: &View, size: [u32; 2], hits: &[Option<Hit>], up: DVec3) -> Vec<f64> {
    let scene = Scene::new(view, size, &[]);
    let Projection { axes, eye, .. } = scene.projection;
    let mut image = vec![0.0; hits.len()];
    for (pixel, _, point) in scene.seen(hits) {
        image[pixel] = (axes.transpose() * point + eye).dot(up.normalize());
    }
    image
}

/// Linear view depth of every pixel in metres; infinite where nothing is seen.
pub fn depth(hits: &[Option<Hit>]) -> Vec<f64> {
    hits.iter().map(|hit| hit.map_or(f64::INFINITY, |hit| hit.depth)).collect()
}

/// Group of every pixel's sphere; 0 where nothing is seen. `groups` are those of the spheres.
pub fn id(hits: &[Option<Hit>], groups: &[u32]) -> Vec<u32> {
    hits.iter().map(|hit| hit.and_then(|hit| groups.get(hit.sphere).copied()).unwrap_or(0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit};
    use crate::view::Camera;

    fn camera() -> Camera {
        Camera { eye: DVec3::ZERO, target: -DVec3::Z, vertical_fov: 90.0, near: 0.5, far: 50.0, ..Camera::default() }
    }

    /// Depths seen in the middle of 5 x 3 pixels.
    fn middle(spheres: &[[f64; 4]]) -> Option<Hit> {
        raycast(&camera().view([5, 3]), [5, 3], spheres)[7]
    }

    #[test]
    fn a_sphere_ahead_is_seen_at_its_front() {
        assert_eq!(middle(&[[0.0, 0.0, -10.0, 2.0]]), Some(Hit { sphere: 0, depth: 8.0 }));
        // Through the pixel to the right, (2 / 3, 0, 1): 13/9 t^2 - 20 t + 96 = 0 has no root; at radius 6 it has.
        let right = |radius| raycast(&camera().view([5, 3]), [5, 3], &[[0.0, 0.0, -10.0, radius]])[8];
        assert_eq!(right(2.0), None);
        let expected = (10.0 - (100.0 - 13.0 / 9.0 * 64.0_f64).sqrt()) / (13.0 / 9.0);
        assert!((right(6.0).unwrap().depth - expected).abs() < 1e-13);
    }

    #[test]
    fn rows_go_down_and_columns_to_the_right() {
        // Up and to the right of the camera's axis: first row, right half.
        let hits = raycast(&camera().view([5, 3]), [5, 3], &[[2.0 / 3.0, 2.0 / 3.0, -1.0, 0.1]]);
        let seen: Vec<usize> = (0..15).filter(|i| hits[*i].is_some()).collect();
        assert_eq!(seen, [3]);
    }

    #[test]
    fn only_front_hits_between_near_and_far_count() {
        assert_eq!(middle(&[[0.0, 0.0, -1.0, 2.0]]), None, "camera inside");
        assert_eq!(middle(&[[0.0, 0.0, 5.0, 2.0]]), None, "behind");
        assert_eq!(middle(&[[0.0, 0.0, -1.0, 0.5]]).unwrap().depth, 0.5, "at the near plane");
        assert_eq!(middle(&[[0.0, 0.0, -1.0, 0.75]]), None, "before the near plane");
        assert_eq!(middle(&[[0.0, 0.0, -51.0, 1.0]]).unwrap().depth, 50.0, "at the far plane");
        assert_eq!(middle(&[[0.0, 0.0, -52.0, 1.0]]), None, "beyond the far plane");
        assert_eq!(middle(&[[0.0, 0.0, -5.0, 0.0], [f64::NAN, 0.0, -5.0, 1.0]]), None, "no sphere");
    }

    #[test]
    fn the_nearest_wins_and_of_equals_the_first() {
        let spheres = [[0.0, 0.0, -9.0, 1.0], [0.0, 0.0, -8.0, 2.0], [0.0, 0.0, -7.0, 1.0], [0.0, 0.0, -20.0, 1.0]];
        assert_eq!(middle(&spheres), Some(Hit { sphere: 1, depth: 6.0 }));
    }

    #[test]
    fn bounds_lose_no_pixel() {
        let camera = Camera {
            eye: DVec3::new(0.3, 0.2, 0.1),
            target: DVec3::new(1.0, 0.5, -2.0),
            vertical_fov: 75.0,
            ..camera()
        };
        let size = [48, 31];
        let random = |i, d, scale: f64| (f64::from(unit(hash(8, i, 0, d))) - 0.5) * scale;
        let sphere = |i| [random(i, 0, 6.0), random(i, 1, 6.0), random(i, 2, 6.0), random(i, 3, 1.0) + 0.5];
        let spheres: Vec<[f64; 4]> = (0..60).map(sphere).collect();
        let hits = raycast(&camera.view(size), size, &spheres);
        let scene = Scene::new(&camera.view(size), size, &spheres);
        for (pixel, hit) in hits.iter().enumerate() {
            let ray = scene.ray(pixel as u32 % 48, pixel as u32 / 48);
            let depths = scene.spheres.iter().map(|s| s.and_then(|(centre, radius)| front(ray, centre, radius)));
            let nearest = depths.flatten().filter(|z| *z >= 0.5).fold(f64::INFINITY, f64::min);
            assert_eq!(hit.map_or(f64::INFINITY, |hit| hit.depth), nearest, "pixel {pixel}");
        }
        let covered = hits.iter().flatten().count();
        assert!(covered > 300 && covered < 48 * 31, "{covered} pixels covered");
    }

    #[test]
    fn luminance_of_the_middle_of_a_sphere() {
        let spheres = [[0.0, 0.0, -10.0, 2.0]];
        let hits = raycast(&camera().view([5, 3]), [5, 3], &spheres);
        let plain = |source| Light { source, ambient: 0.2, fill: 0.0, ..Light::default() };
        let middle =
            |source, s| luminance(&camera().view([5, 3]), [5, 3], &spheres, &hits, &plain(source), &[s; 15])[7];
        // The normal is +z. Light from straight ahead, at 60 degrees, from behind, from a point above the hit's level.
        let direction = |x, z| LightSource::Direction(DVec3::new(x, 0.0, z));
        assert!((middle(direction(0.0, -3.0), 1.0) - 1.0).abs() < 1e-15);
        assert!((middle(direction(3.0_f64.sqrt(), -1.0), 1.0) - (0.2 + 0.8 * 0.5)).abs() < 1e-15);
        assert!((middle(direction(3.0_f64.sqrt(), -1.0), 0.25) - (0.2 + 0.8 * 0.125)).abs() < 1e-15);
        assert_eq!(middle(direction(0.0, 1.0), 1.0), 0.2);
        let point = LightSource::Position(DVec3::new(0.0, 3.0, -4.0));
        assert!((middle(point, 1.0) - (0.2 + 0.8 * 0.8)).abs() < 1e-15);
        // In the light itself there is no direction to it.
        assert_eq!(middle(LightSource::Position(DVec3::new(0.0, 0.0, -8.0)), 1.0), 0.2);
        let image = luminance(&camera().view([5, 3]), [5, 3], &spheres, &hits, &Light::default(), &[1.0; 15]);
        assert_eq!(image[0], 0.0);
    }
}
