//! The flame effect under validation, and everything that it makes read back.

use celfx::data::Particles;
use celfx::effect::{DeviceTraits, Effort};
use celfx::flame::FlameKind;
use celfx::flame::{Desc, Settings};
use celfx::low_level::flame::layout;
use celfx::low_level::flame::params::{MASK_SIDE, Particle};
use celfx::low_level::plan::BufferId;
use celfx::offline::{EffectBuffer, Offline, Scene, TARGET_FORMAT};
use celfx::toon::LINES;
use celfx::view::Camera;

use super::rig::Bits;
use super::{TestOffline, device, host};

/// The effect on a device of its own.
pub struct FlameRig {
    offline: TestOffline,
    desc: Desc,
    /// Of the frame rendered last.
    particles: usize,
    /// What scratch memory is filled with before each frame, if it is.
    pub poison: Option<u32>,
}

/// An effect of this picture size for at most so many particles, with every layer kept, and without a scene; sizes are pixels of
/// the picture. Particles
/// above `settings.hottest` count as that hot; a spread that is not given is 0.1 m.
pub fn desc(size: [u32; 2], particles: u32, settings: Settings) -> Desc {
    Desc {
        size,
        lines: Some(LINES),
        target_format: TARGET_FORMAT,
        scene: None,
        accumulates: true,
        particles,
        hottest: settings.hottest,
        seed: 1,
        settings: Settings { spread: settings.spread.or(Some(0.1)), ..settings },
        layers: true,
        temporal: Default::default(),
    }
}

/// A rendered frame number 0.
pub fn scene(particles: Option<&Particles>, camera: Camera) -> Scene<'_> {
    Scene { camera, particles, rendered: true, ..Scene::default() }
}

/// Particles from rows of x, y, z and temperature, without ids.
pub fn particles(rows: &[[f32; 4]]) -> Particles {
    Particles {
        position: rows.iter().map(|[x, y, z, _]| [*x, *y, *z]).collect(),
        temperature: rows.iter().map(|row| row[3]).collect(),
        id: None,
        velocity: None,
    }
}

/// `count` particles, random in a ball of 1 m around the origin, of 300 to 3000 K.
pub fn ball(count: u32, key: u32) -> Particles {
    let random = |index, dimension| super::scenes::random(key, index, dimension);
    let row = |i: u32| {
        let (turn, height) = (std::f32::consts::TAU * random(i, 0), 2.0 * random(i, 1) - 1.0);
        let (radius, ring) = (random(i, 2).cbrt(), (1.0 - height * height).sqrt());
        let [x, y, z] = [ring * turn.cos(), height, ring * turn.sin()].map(|x| x * radius);
        [x, y, z, 300.0 + 2700.0 * random(i, 3)]
    };
    particles(&(0..count).map(row).collect::<Vec<_>>())
}

/// The particles, each with a velocity of up to 2 m/s a direction.
pub fn moving(particles: Particles, key: u32) -> Particles {
    let component = |index, dimension| 4.0 * super::scenes::random(key, index, dimension) - 2.0;
    let velocity = (0..particles.position.len() as u32).map(|i| [0, 1, 2].map(|c| component(i, c)));
    Particles { velocity: Some(velocity.collect()), ..particles }
}

/// The same of three temperatures: for what does not depend on them, and renders many expected images, which take longest
/// by far to make the table of each class of temperatures.
pub fn embers(count: u32, key: u32) -> Particles {
    let mut particles = ball(count, key);
    particles.temperature.iter_mut().zip([1500.0, 2200.0, 2900.0].into_iter().cycle()).for_each(|(own, t)| *own = t);
    particles
}

impl FlameRig {
    /// None where there is no device and tests may do without.
    pub fn new(desc: Desc) -> Option<FlameRig> {
        FlameRig::with_effort(desc, Effort::Needed)
    }

    pub fn with_effort(desc: Desc, effort: Effort) -> Option<FlameRig> {
        let offline = device()?.offline(desc.clone(), effort).expect("the effect can be made");
        Some(FlameRig { offline, desc, particles: 0, poison: None })
    }

    /// Fitted to what `change` makes of the device's traits.
    pub fn fitted(desc: Desc, change: impl FnOnce(&mut DeviceTraits)) -> Option<FlameRig> {
        let device = device()?.fitted(change);
        let offline = device.offline(desc.clone(), Effort::Needed).expect("the effect can be made");
        Some(FlameRig { offline, desc, particles: 0, poison: None })
    }

    pub fn desc(&self) -> &Desc {
        &self.desc
    }

    pub fn offline(&mut self) -> &mut Offline {
        &mut self.offline
    }

    /// Renders frame number 0 of these particles, which must succeed.
    pub fn frame(&mut self, particles: &Particles, camera: Camera) {
        self.render(&scene(Some(particles), camera));
    }

    /// Renders a frame, which must succeed: with a scene depth, another number, accumulated.
    pub fn render(&mut self, scene: &Scene) {
        if let Some(word) = self.poison {
            let scratch = self.offline.effect::<FlameKind>().expect("an effect").scratch();
            host::poison(self.offline.device_mut(), scratch, word);
        }
        self.offline.frame(scene).expect("the frame can be rendered");
        self.particles = scene.particles.map_or(self.particles, |particles| particles.position.len());
    }

    fn read<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId, count: usize) -> Vec<T> {
        let values = self.offline.read_as(EffectBuffer::of::<FlameKind>(id), count).expect("the buffer can be read");
        assert_eq!(values.len(), count, "{id:?} is smaller");
        values
    }

    /// A value a pixel of one of the buffers.
    fn pixels<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId) -> Vec<T> {
        let [width, height] = self.desc.size.map(|side| side as usize);
        self.read(id, width * height)
    }

    /// Linear RGBA, premultiplied: the effect over the background.
    pub fn picture(&self) -> Vec<[f32; 4]> {
        self.offline.picture().to_vec()
    }

    /// x, y, z and temperature of each particle, as it was uploaded.
    pub fn positions(&mut self) -> Vec<[f32; 4]> {
        self.read(layout::POSITIONS, self.particles)
    }

    /// What became of each particle; dropped ones have a `count` of 0.
    pub fn prepared(&mut self) -> Vec<Particle> {
        self.read(layout::PARTICLES, self.particles)
    }

    /// How each particle's sprites are drawn out: w, as two halves.
    pub fn stretches(&mut self) -> Vec<[f64; 2]> {
        let halves: Vec<u32> = self.read(layout::STRETCHES, self.particles);
        let half = |bits: u32| exr::prelude::f16::from_bits(bits as u16).to_f64();
        halves.iter().map(|word| [half(word & 0xFFFF), half(word >> 16)]).collect()
    }

    /// The masks, one after the other, rows from the top.
    pub fn mask(&mut self) -> Vec<f32> {
        let count = self.desc.settings.variants * MASK_SIDE * MASK_SIDE;
        self.read(layout::MASK, count as usize)
    }

    /// Mean RGB before exposure, and coverage.
    pub fn mean(&mut self) -> Vec<[f32; 4]> {
        self.pixels(layout::MEAN)
    }

    /// Variance of one repetition's RGB, and the number of repetitions.
    pub fn variance(&mut self) -> Vec<[f32; 4]> {
        self.pixels(layout::VARIANCE)
    }

    /// Mean view depth of the nearest render particles in metres; infinite where there are none.
    pub fn nearest(&mut self) -> Vec<f32> {
        self.pixels(layout::NEAREST)
    }

    /// Linear RGBA, premultiplied by coverage: the effect alone.
    pub fn effect(&mut self) -> Vec<[f32; 4]> {
        self.pixels(layout::PICTURE)
    }

    /// Smoothed heat.
    pub fn heat(&mut self) -> Vec<f32> {
        self.pixels::<[f32; 2]>(layout::HEAT_LAYER).into_iter().map(|[heat, _]| heat).collect()
    }

    /// Linear RGBA of tones alone, premultiplied.
    pub fn tone(&mut self) -> Vec<[f32; 4]> {
        self.pixels(layout::TONE_LAYER)
    }

    /// Opacity of the line.
    pub fn outline(&mut self) -> Vec<f32> {
        self.pixels::<[f32; 2]>(layout::HEAT_LAYER).into_iter().map(|[_, line]| line).collect()
    }

    /// Every layer of a frame, bit for bit; what is in the rows of dropped particles does not matter.
    pub fn bits(&mut self) -> Bits {
        let mut bits = Bits::default();
        bits.push("picture", &self.picture());
        let kept = self.prepared().into_iter().filter(|particle| particle.count > 0);
        bits.push("particles", &kept.collect::<Vec<_>>());
        bits.push("mask", &self.mask());
        bits.push("mean", &self.mean());
        bits.push("variance", &self.variance());
        bits.push("nearest", &self.nearest());
        bits.push("effect", &self.effect());
        bits.push("heat", &self.heat());
        bits.push("tone", &self.tone());
        bits.push("outline", &self.outline());
        bits
    }
}
