//! Scenes that several tests render, and what they compare images by.

use celfx::data::Particles;
use celfx::effect::Effort;
use celfx::flame::FlameKind;
use celfx::flame::reference::expected::Bins;
use celfx::flame::reference::mask::{self, Mask};
use celfx::flame::reference::prepare;
use celfx::flame::reference::stochastic::Frame;
use celfx::flame::settings::Mode;
use celfx::flame::{Desc, Settings};
use celfx::low_level::flame::layout;
use celfx::low_level::flame::params::Control;
use celfx::offline::{EffectBuffer, Scene};
use celfx::view::{Camera, Projection, View};
use glam::DVec3;

use crate::common::flame::{FlameRig, ball, desc, embers, scene};
use crate::common::scenes;

/// What is rendered.
#[derive(Clone)]
pub struct Case {
    pub name: &'static str,
    pub desc: Desc,
    pub camera: Camera,
    /// What it is seen through instead, if it is not a camera's.
    pub view: Option<View>,
    pub particles: Particles,
    /// View depth of the scene a pixel, if the effect is made for one.
    pub depth: Option<Vec<f32>>,
}

/// The expected image of fire whose sprites are about as large as the spaces that they fill.
pub fn settings() -> Settings {
    Settings {
        mode: Mode::Expected,
        spread: Some(0.2),
        size: Some(0.25),
        count: 10.0,
        variants: 4,
        ..Settings::paper()
    }
}

impl Case {
    /// Particles in a ball of 1 m around the origin.
    pub fn new(name: &'static str, size: [u32; 2], count: u32, settings: Settings, camera: Camera) -> Case {
        Case { name, desc: desc(size, count, settings), camera, view: None, particles: ball(count, 3), depth: None }
    }

    /// The same with other settings.
    pub fn with(&self, change: impl FnOnce(&mut Settings)) -> Case {
        let mut case = self.clone();
        change(&mut case.desc.settings);
        case
    }

    /// The same of three temperatures.
    pub fn embers(&self) -> Case {
        Case { particles: embers(self.desc.particles, 3), ..self.clone() }
    }

    /// The same from so many times as far away, as large in the picture.
    pub fn away(&self, times: f64) -> Case {
        let fov = 2.0 * ((self.camera.vertical_fov.to_radians() / 2.0).tan() / times).atan().to_degrees();
        let camera = Camera { eye: self.camera.eye * times, vertical_fov: fov, far: f64::INFINITY, ..self.camera };
        Case { camera, ..self.clone() }
    }

    /// The same, all lengths of it so many times as long.
    pub fn scaled(&self, times: f32) -> Case {
        let mut case = self.clone();
        case.particles.position.iter_mut().flatten().for_each(|x| *x *= times);
        let settings = &mut case.desc.settings;
        for length in [&mut settings.spread, &mut settings.size].into_iter().flatten() {
            *length *= times;
        }
        let Camera { eye, near, far, .. } = self.camera;
        let times = f64::from(times);
        case.camera = Camera { eye: eye * times, near: near * times, far: far * times, ..self.camera };
        case
    }

    /// Rendered by an effect of its own.
    pub fn render(&self) -> Option<FlameRig> {
        self.render_with(Effort::Needed)
    }

    pub fn render_with(&self, effort: Effort) -> Option<FlameRig> {
        let mut rig = FlameRig::with_effort(self.desc.clone(), effort)?;
        self.render_by(&mut rig);
        Some(rig)
    }

    /// Rendered by an effect that was made for it.
    pub fn render_by(&self, rig: &mut FlameRig) {
        rig.render(&Scene {
            depth: self.depth.as_deref(),
            view: self.view,
            ..scene(Some(&self.particles), self.camera)
        });
    }
}

/// All of the fire in the middle of the picture, from 4 m.
pub fn plain() -> Case {
    Case::new("plain", [48, 36], 60, settings(), scenes::camera(25.0))
}

/// A wide lens past which fire burns in a corner of the picture: rays slant by up to 1.6 a metre.
pub fn wide() -> Case {
    let camera = Camera {
        eye: DVec3::new(0.0, 0.1, 1.7),
        target: DVec3::new(-1.3, -0.9, 0.6),
        vertical_fov: 100.0,
        ..Camera::default()
    };
    Case::new("wide", [48, 36], 30, settings(), camera)
}

/// So near that perspective is strong within a particle and sprites are large: the mask is magnified.
pub fn near() -> Case {
    let camera =
        Camera { eye: DVec3::new(0.1, 0.0, 1.15), target: DVec3::ZERO, vertical_fov: 60.0, ..Camera::default() };
    Case::new("near", [40, 30], 24, settings(), camera)
}

/// As users have it: the defaults, with the usual spread of 300 particles.
pub fn usual() -> Case {
    let particles = ball(300, 3);
    let spread = celfx::flame::mean_spacing(&particles.position);
    let settings = Settings { mode: Mode::Expected, spread, ..Settings::paper() };
    Case { particles, ..Case::new("usual", [40, 30], 300, settings, scenes::camera(25.0)) }
}

/// The same from so far away that rays are parallel: what the tables' bounds were measured on.
pub fn parallel() -> Case {
    Case { name: "parallel", ..usual().away(30.0) }
}

/// What the device has decided.
pub fn control(rig: &mut FlameRig) -> Control {
    let read = rig.offline().read_as(EffectBuffer::of::<FlameKind>(layout::CONTROL), 1);
    read.expect("the buffer can be read")[0]
}

/// A float from the number that orders as it does.
pub fn from_ordered(word: u32) -> f32 {
    f32::from_bits(if word >> 31 == 1 { word ^ 1 << 31 } else { !word })
}

/// The bins of the device's frame.
pub fn bins(rig: &mut FlameRig) -> Bins {
    let control = control(rig);
    let base = f64::from(f32::from_bits(control.base));
    let is_far = base > 0.0;
    let low = if is_far { control.depth_low } else { control.range_low };
    let high = if is_far { control.depth_high } else { control.range_high };
    let [near, far] = [low, high].map(|word| base + f64::from(from_ordered(word)));
    Bins { near, far, count: rig.desc().settings.bins as usize }
}

/// The device's mask.
pub fn device_mask(rig: &mut FlameRig) -> Mask {
    Mask::from_texels(rig.mask().into_iter().map(f64::from).collect())
}

/// The level of the mask in the device's frame.
pub fn level(case: &Case, rig: &mut FlameRig) -> u32 {
    let nearest = f32::from_bits(control(rig).nearest);
    prepare::mask_level(&case.desc.settings, &case.seen(), case.desc.size, nearest.into())
}

/// The device's particles as the references take them: with its counts, alphas and colours.
pub fn prepared(case: &Case, rig: &mut FlameRig) -> Vec<prepare::Particle> {
    let brightest = f64::from(f32::from_bits(control(rig).brightest));
    let stretches = rig.stretches();
    let rows = rig.prepared().into_iter().zip(&case.particles.position).enumerate();
    let particle = |(row, (given, centre)): (usize, (celfx::low_level::flame::params::Particle, &[f32; 3]))| {
        let colour = [0, 1, 2].map(|c| f64::from(given.colour[c]));
        prepare::Particle {
            row: row as u32,
            id: given.id,
            centre: *centre,
            alpha: given.colour[3].into(),
            mean_count: given.mean_count.into(),
            count: given.count,
            colour,
            light: colour.map(|c| prepare::light(c, brightest)),
            stretch: stretches[row],
        }
    };
    rows.map(particle).collect()
}

impl Case {
    /// What it is seen through.
    pub fn seen(&self) -> View {
        self.view.unwrap_or_else(|| self.camera.view(self.desc.size))
    }

    /// The same, taken apart.
    pub fn projection(&self) -> Projection {
        Projection::of_valid(&self.seen(), self.desc.size)
    }

    /// As the references take it.
    pub fn frame<'a>(&'a self, mask: &'a Mask, level: u32) -> Frame<'a> {
        Frame {
            settings: &self.desc.settings,
            seed: self.desc.seed,
            number: 0,
            view: self.seen(),
            size: self.desc.size,
            scene: self.depth.as_deref(),
            mask,
            level,
            base: 0.0,
        }
    }
}

/// Root mean square of what two images differ by, over all channels of all pixels, and the largest difference.
pub fn apart(a: &[[f32; 4]], b: &[[f64; 3]]) -> [f64; 2] {
    assert_eq!(a.len(), b.len());
    let channels = a.iter().zip(b).flat_map(|(a, b)| (0..3).map(|c| crate::common::apart(a[c], b[c])));
    let (sum, most) = channels.fold((0.0, 0.0_f64), |(sum, most), d| (sum + d * d, most.max(d)));
    [(sum / (3 * a.len()) as f64).sqrt(), most]
}

/// RGB in f64.
pub fn rgb(pixels: &[[f32; 4]]) -> Vec<[f64; 3]> {
    pixels.iter().map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect()
}

/// Alphas of a level, sorted within each texel, are looked up at the side of a level.
pub const SIDE: usize = mask::SIDE;
