//! Volumes, cameras and descriptions that several tests use.

use celfx::data::Volume;
use celfx::low_level::random::{hash, unit};
use celfx::offline::TARGET_FORMAT;
use celfx::smoke::settings::{Antialias, LINES, RadiusFrom};
use celfx::smoke::{Desc, Settings};
use celfx::view::{Camera, Light, LightSource};
use glam::DVec3;

/// A random number in (0, 1), from counters alone.
pub fn random(key: u32, index: u32, dimension: u32) -> f32 {
    unit(hash(key, index, 0, dimension))
}

/// Radii and density as the paper has them: whoever tests these, or what hangs on a voxel's being empty, begins with this.
pub fn of_voxels() -> Settings {
    Settings { radius_from: RadiusFrom::Voxels, detail: Some(0.0), ..Settings::default() }
}

/// An effect of this picture and volume size with every layer kept; sizes are pixels of the picture. Small spheres are drawn, too, and
/// pixels have smoke or not, so that stages can be compared.
pub fn desc(size: [u32; 2], dimensions: [u32; 3], settings: Settings) -> Desc {
    drawn(size, dimensions, Settings { smallest: 0.0, antialias: Antialias::None, ..settings })
}

/// The same with all that settings say.
pub fn drawn(size: [u32; 2], dimensions: [u32; 3], settings: Settings) -> Desc {
    let new = Desc::new(size, dimensions, settings);
    Desc { lines: Some(LINES), target_format: TARGET_FORMAT, seed: 1, layers: true, ..new }
}

/// A volume whose density is a function of the voxel.
pub fn volume(
    dimensions: [u32; 3],
    voxel_size: [f32; 3],
    origin: [f32; 3],
    density: impl Fn(u32, u32, u32) -> f32,
) -> Volume {
    let [nx, ny, nz] = dimensions;
    let mut values = Vec::with_capacity((nx * ny * nz) as usize);
    for z in 0..nz {
        for y in 0..ny {
            values.extend((0..nx).map(|x| density(x, y, z)));
        }
    }
    Volume { dimensions, voxel_size, origin, density: values, velocity: None }
}

/// Three balls of smoke in a box of 2 m around the origin, lumpy, as the frames of a rising sequence.
pub fn puffs(n: u32, time: f32) -> Volume {
    let h = 2.0 / n as f32;
    let balls = [[-0.35, -0.4, 0.1, 0.45], [0.3, -0.1, -0.25, 0.4], [0.0, 0.35, 0.2, 0.38]];
    volume([n; 3], [h; 3], [-1.0; 3], |x, y, z| {
        let p = [x, y, z].map(|i| (i as f32 + 0.5) * h - 1.0);
        let lump = 0.08 * (9.0 * p[0]).sin() * (8.0 * p[1] + 2.0).sin() * (7.0 * p[2] + 1.0).sin();
        let depth = balls.iter().map(|[bx, by, bz, r]| {
            let d = [p[0] - bx, p[1] - by - 0.25 * time, p[2] - bz];
            r + lump - (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
        });
        depth.fold(f32::MIN, f32::max).clamp(0.0, 0.1) * 10.0
    })
}

/// [`puffs`] with a velocity: up, and around the vertical axis.
pub fn moving_puffs(n: u32, time: f32) -> Volume {
    let mut volume = puffs(n, time);
    let h = volume.voxel_size[0];
    let velocity = (0..n * n * n).map(|i| {
        let p = [i % n, i / n % n, i / n / n].map(|i| (i as f32 + 0.5) * h - 1.0);
        [-0.8 * p[2], 0.5 + 0.2 * p[0], 0.8 * p[0]]
    });
    volume.velocity = Some(velocity.collect());
    volume
}

/// Looks at the origin from 4 m, turned by `degrees` around the vertical axis.
pub fn camera(degrees: f64) -> Camera {
    let angle = degrees.to_radians();
    Camera {
        eye: DVec3::new(4.0 * angle.sin(), 0.6, 4.0 * angle.cos()),
        target: DVec3::ZERO,
        vertical_fov: 32.0,
        ..Camera::default()
    }
}

/// Light from a direction: the way it travels.
pub fn direction(x: f64, y: f64, z: f64) -> Light {
    Light { source: LightSource::Direction(DVec3::new(x, y, z)), ..Light::default() }
}

/// Light at a point in metres.
pub fn point(x: f64, y: f64, z: f64) -> Light {
    Light { source: LightSource::Position(DVec3::new(x, y, z)), ..Light::default() }
}
