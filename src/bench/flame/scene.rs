//! Measured scenes: particles, cameras, sprites. A sprite is 13 pixels wide in a picture 512 pixels high.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::bench::rig::{EffectId, FORMAT, Rig};
use crate::data::Particles;
use crate::error::Result;
use crate::flame::layout::PICTURE;
use crate::flame::{Desc, Settings, mean_spacing};
use crate::offline;
use crate::random::{hash, unit};
use crate::simulate::flame::Builtin;
use crate::view::Camera;

/// Seed of the effects.
pub(super) const SEED: u32 = 0;
/// Mean number of render particles of a particle in a repetition: the paper has 50,000 of 2,500.
const MEAN_COUNT: f64 = 20.0;
/// The frame of the built-in fire that is measured: the torch has risen by then.
const FRAME: u32 = 24;
const FPS: f64 = 24.0;
/// Side of a sprite in pixels where the camera looks.
const SPRITE: f64 = 13.0;
/// Radius of the ball in heights of the picture.
const BALL_RADIUS: f64 = 0.4;

/// Where particles are.
#[derive(Clone, Copy, Debug)]
pub(super) enum Fire {
    /// Of the built-in torch, evenly chosen among its 2,500.
    Torch,
    /// Random in a ball, each with so many pixels around it.
    Ball(f64),
}

/// A fire as it is measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Workload {
    pub(super) name: &'static str,
    pub(super) fire: Fire,
    pub(super) size: [u32; 2],
    pub(super) particles: u32,
    /// Side of a sprite in pixels.
    pub(super) sprite: f64,
    /// The divisor of the picture's sides with `--quick`, and the square of which the particles; 1 leaves it as it is.
    pub(super) cut: u32,
}

/// The paper's frame: 2,500 physical particles, 50,000 render particles a repetition.
pub(super) const PAPER: Workload =
    Workload { name: "paper", fire: Fire::Torch, size: [512, 512], particles: 2500, sprite: SPRITE, cut: 4 };
/// The same fire in full HD.
pub(super) const FULL_HD: Workload = Workload { name: "1920x1080", size: [1920, 1080], sprite: 27.0, ..PAPER };
/// Some 30 sprites lie over a pixel of the ball.
pub(super) const THICK: Workload =
    Workload { name: "thick", fire: Fire::Ball(10.0), size: [256, 256], particles: 280, sprite: SPRITE, cut: 2 };
/// An eighth of them: of 4 over a pixel, one or two pass.
pub(super) const THIN: Workload = Workload { name: "thin", particles: 36, cut: 1, ..THICK };

/// A workload on the device and in the reference.
pub(super) struct Scene {
    /// The workload's name, and its size where that was cut.
    pub(super) name: String,
    pub(super) size: [u32; 2],
    pub(super) particles: Particles,
    pub(super) camera: Camera,
    /// Everything but what variants differ in.
    pub(super) settings: Settings,
}

impl Scene {
    pub(super) fn new(workload: &Workload, quick: bool) -> Scene {
        let cut = if quick { workload.cut } else { 1 };
        let size = workload.size.map(|side| side / cut);
        let count = workload.particles / (cut * cut);
        let name = match cut {
            1 => workload.name.to_owned(),
            _ => format!("{} (cut to {}x{}, {count} particles)", workload.name, size[0], size[1]),
        };
        let camera = match workload.fire {
            Fire::Torch => Camera {
                eye: DVec3::new(0.0, 0.62, 2.6),
                target: DVec3::new(0.0, 0.62, 0.0),
                vertical_fov: 32.0,
                ..Camera::default()
            },
            Fire::Ball(_) => Camera { eye: 4.0 * DVec3::Z, target: DVec3::ZERO, ..Camera::default() },
        };
        // Metres that a pixel is where the camera looks.
        let distance = (camera.target - camera.eye).length();
        let pixel = 2.0 * camera.half_extent(size).y * distance / f64::from(size[1]);
        let (particles, spread) = match workload.fire {
            Fire::Torch => {
                let particles = torch(count);
                let spread = mean_spacing(&particles.position);
                (particles, spread)
            }
            Fire::Ball(around) => {
                let particles = ball(count, BALL_RADIUS * f64::from(size[1]) * pixel);
                (particles, Some((around * pixel) as f32))
            }
        };
        let kelvin = particles.temperature.iter().map(|t| f64::from(*t)).sum::<f64>() / f64::from(count.max(1));
        let defaults = Settings::paper();
        let settings = Settings {
            spread,
            size: Some((workload.sprite * pixel) as f32),
            count: (MEAN_COUNT * f64::from(defaults.hottest) / kelvin) as f32,
            ..defaults
        };
        Scene { name, size, particles, camera, settings }
    }

    /// Description of an effect with such settings.
    pub(super) fn desc(&self, settings: Settings) -> Desc {
        let new = Desc::new(self.size, self.particles.position.len() as u32, settings);
        Desc { target_format: FORMAT, seed: SEED, ..new }
    }

    /// A frame of it.
    pub(super) fn scene(&self) -> offline::Scene<'_> {
        offline::Scene {
            camera: self.camera,
            particles: Some(&self.particles),
            rendered: true,
            ..offline::Scene::default()
        }
    }

    /// Makes an effect and renders a frame, which compiles every kernel.
    pub(super) fn render(&self, rig: &mut Rig, settings: Settings) -> Result<EffectId> {
        let effect = rig.effect(self.desc(settings))?;
        rig.frame(effect, &self.scene())?;
        Ok(effect)
    }

    /// Mean colour of each pixel of a frame: intensity is 1.
    pub(super) fn mean(&self, rig: &mut Rig, effect: EffectId) -> Result<Vec<[f32; 4]>> {
        rig.read(effect, PICTURE, self.size[0] as usize * self.size[1] as usize)
    }
}

fn torch(count: u32) -> Particles {
    let Particles { position, temperature, id, .. } = Builtin::Random.particles(FRAME, FPS);
    let every = (position.len() / count.max(1) as usize).max(1);
    let ids = id.unwrap_or_default();
    Particles {
        position: position.into_iter().step_by(every).take(count as usize).collect(),
        temperature: temperature.into_iter().step_by(every).take(count as usize).collect(),
        id: Some(ids.into_iter().step_by(every).take(count as usize).collect()),
        velocity: None,
    }
}

/// 900 to 3000 K, evenly.
fn ball(count: u32, radius: f64) -> Particles {
    let draw = |index, dimension| f64::from(unit(hash(2, index, 0, dimension)));
    let position = |i| {
        let (sin, cos) = (TAU * draw(i, 0)).sin_cos();
        let height = 2.0 * draw(i, 1) - 1.0;
        let ring = (1.0 - height * height).sqrt();
        let place = radius * draw(i, 2).cbrt() * DVec3::new(ring * cos, height, ring * sin);
        place.as_vec3().to_array()
    };
    Particles {
        position: (0..count).map(position).collect(),
        temperature: (0..count).map(|i| (900.0 + 2100.0 * draw(i, 3)) as f32).collect(),
        id: None,
        velocity: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flame::reference::prepare::prepare;

    #[test]
    fn the_papers_frame_has_its_numbers() {
        let scene = Scene::new(&PAPER, false);
        let Scene { particles: Particles { position, temperature, .. }, settings, camera, .. } = &scene;
        assert_eq!((scene.name.as_str(), scene.size, position.len()), ("paper", [512, 512], 2500));
        let rows = position.iter().zip(temperature).map(|([x, y, z], t)| [*x, *y, *z, *t]);
        let prepared = prepare(settings, 3000.0, SEED, &camera.view(scene.size), &rows.collect::<Vec<_>>(), None);
        let sprites: u32 = prepared.particles.iter().map(|particle| particle.count).sum();
        assert!((49_000..51_000).contains(&sprites), "{sprites}");
        let focal = 256.0 / camera.half_extent(scene.size).y;
        let side = f64::from(settings.sprite()) * focal / 2.6;
        assert!((side - 13.0).abs() < 1e-3, "{side}");
    }

    #[test]
    fn a_quick_scene_says_what_it_is() {
        let scene = Scene::new(&PAPER, true);
        assert_eq!(scene.name, "paper (cut to 128x128, 156 particles)");
        assert_eq!((scene.size, scene.particles.position.len()), ([128, 128], 156));
        assert_eq!(Scene::new(&THIN, true).name, "thin");
    }
}
