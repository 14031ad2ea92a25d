//! The whole effect under validation, and everything that it makes read back.

use celfx::data::Volume;
use celfx::effect::Effort;
use celfx::low_level::plan::BufferId;
use celfx::low_level::smoke::layout;
use celfx::low_level::smoke::params::{Control, Particle};
use celfx::offline::{EffectBuffer, Offline, Scene};
use celfx::smoke::SmokeKind;
use celfx::smoke::reference;
use celfx::smoke::reference::Lights;
use celfx::smoke::reference::groups::Ranges;
use celfx::smoke::settings::LINES;
use celfx::smoke::{Desc, Sequence};
use celfx::view::{Camera, Light, View};

use super::host::POISONS;
use super::{TestOffline, device, host};

/// The effect on a device of its own.
pub struct Rig {
    offline: TestOffline,
    desc: Desc,
    /// What scratch memory is filled with before each frame, if it is.
    pub poison: Option<u32>,
}

/// A frame at `dt` = 1/24 s, rendered.
pub fn scene<'a>(sequence: Sequence, camera: Camera, light: Light, volume: Option<&'a Volume>) -> Scene<'a> {
    Scene { sequence, dt: 1.0 / 24.0, camera, light, volume, rendered: true, ..Scene::default() }
}

/// Bits of every layer of a frame, to be compared with another's.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Bits(Vec<(&'static str, Vec<u32>)>);

impl Bits {
    /// Adds a layer of values of whole words.
    pub fn push<T: bytemuck::NoUninit>(&mut self, name: &'static str, values: &[T]) {
        self.0.push((name, bytemuck::cast_slice(values).to_vec()));
    }

    /// Names of the layers in which two frames differ, and in how many words. Both must have the same layers.
    #[track_caller]
    pub fn differences(&self, other: &Bits) -> Vec<(&'static str, usize)> {
        let names = |bits: &Bits| bits.0.iter().map(|(name, _)| *name).collect::<Vec<_>>();
        assert!(!self.0.is_empty() && names(self) == names(other), "{:?}, {:?}", names(self), names(other));
        let pairs = self.0.iter().zip(&other.0);
        let count = |((name, a), (_, b)): (&(&'static str, Vec<u32>), &(_, Vec<u32>))| {
            (*name, a.iter().zip(b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len()))
        };
        pairs.map(count).filter(|(_, words)| *words > 0).collect()
    }
}

impl Rig {
    /// None where there is no device and tests may do without.
    pub fn new(desc: Desc) -> Option<Rig> {
        Rig::with_effort(desc, Effort::Needed)
    }

    pub fn with_effort(desc: Desc, effort: Effort) -> Option<Rig> {
        let offline = device()?.offline(desc.clone(), effort).expect("the effect can be made");
        Some(Rig { offline, desc, poison: None })
    }

    pub fn desc(&self) -> &Desc {
        &self.desc
    }

    pub fn offline(&mut self) -> &mut Offline {
        &mut self.offline
    }

    /// Renders a frame, which must succeed.
    pub fn frame(&mut self, scene: &Scene) {
        if let Some(word) = self.poison {
            let scratch = self.offline.effect::<SmokeKind>().expect("an effect").scratch();
            host::poison(self.offline.device_mut(), scratch, word);
        }
        self.offline.frame(scene).expect("the frame can be rendered");
    }

    fn read<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId, count: usize) -> Vec<T> {
        let values = self.offline.read_as(EffectBuffer::of::<SmokeKind>(id), count).expect("the buffer can be read");
        assert_eq!(values.len(), count, "{id:?} is smaller");
        values
    }

    fn pixel_count(&self) -> usize {
        (self.desc.size[0] * self.desc.size[1]) as usize
    }

    fn sphere_count(&self) -> usize {
        (self.desc.settings.particles * (1 + self.desc.settings.fade)) as usize
    }

    pub fn picture(&self) -> Vec<[f32; 4]> {
        self.offline.picture().to_vec()
    }

    pub fn particles(&mut self) -> Vec<Particle> {
        self.read(layout::PARTICLES, self.desc.settings.particles as usize)
    }

    /// Centre and displayed radius; slots first, then the ring.
    pub fn spheres(&mut self) -> Vec<[f32; 4]> {
        let count = self.sphere_count();
        self.read(layout::SPHERES, count)
    }

    pub fn groups(&mut self) -> Vec<u32> {
        let count = self.sphere_count();
        self.read(layout::GROUPS, count)
    }

    /// The ranges of depth that groups are.
    pub fn ranges(&mut self) -> Ranges {
        let Control { group_start, groups_per_metre, .. } = self.read::<Control>(layout::CONTROL, 1)[0];
        Ranges::of_device(group_start, groups_per_metre, self.desc.settings.group_count())
    }

    /// A layer of one value a pixel: `DEPTH`, `SHADOW`, `SMOOTH`.
    pub fn layer(&mut self, id: BufferId) -> Vec<f32> {
        let count = self.pixel_count();
        self.read(id, count)
    }

    /// A layer of four values a pixel: `PICTURE`, `TONE_LAYER`, `MATTE_LAYER`, `OVERLAY_LAYER`.
    pub fn colours(&mut self, id: BufferId) -> Vec<[f32; 4]> {
        let count = self.pixel_count();
        self.read(id, count)
    }

    /// Luminance and group of each pixel.
    pub fn pixels(&mut self) -> (Vec<f64>, Vec<u32>) {
        let count = self.pixel_count();
        super::unpacked(&self.read(layout::PIXELS, count))
    }

    /// Everything that a frame leaves, bit for bit.
    pub fn bits(&mut self) -> Bits {
        let count = self.pixel_count();
        let spheres = self.sphere_count();
        let particles = self.desc.settings.particles as usize;
        let mut bits = Bits::default();
        bits.push("picture", &self.picture());
        // Ages stand still while motion is skipped, which is only where nothing depends on them any more.
        let mut lives: Vec<u32> = self.read(layout::PARTICLES, 8 * particles);
        lives.iter_mut().skip(3).step_by(8).for_each(|age| *age = u32::from(*age == u32::MAX));
        bits.push("particles", &lives);
        for (name, id, words) in [
            ("spheres", layout::SPHERES, 4 * spheres),
            ("groups", layout::GROUPS, spheres),
            ("pixels", layout::PIXELS, count),
            ("depth", layout::DEPTH, count),
            ("shadow", layout::SHADOW, count),
            ("effect", layout::PICTURE, 4 * count),
            ("tone", layout::TONE_LAYER, 4 * count),
            ("mattes", layout::MATTE_LAYER, 4 * count),
            ("overlay", layout::OVERLAY_LAYER, 4 * count),
        ] {
            bits.push(name, &self.read::<u32>(id, words));
        }
        if self.desc.settings.sigma > 0.0 {
            bits.push("smooth", &self.read::<u32>(layout::SMOOTH, count));
        }
        bits
    }

    /// The reference's frame of the spheres and groups that the device has.
    pub fn expected<'a>(&mut self, view: &View, lights: impl Into<Lights<'a>>, voxel: f32) -> reference::Frame {
        let spheres: Vec<[f64; 4]> = self.spheres().iter().map(|s| s.map(f64::from)).collect();
        let (groups, ranges) = (self.groups(), self.ranges());
        let Desc { settings, size, .. } = &self.desc;
        let grouping = reference::Grouping { groups: &groups, ranges };
        let settings = settings.in_pixels(LINES);
        reference::frame(&settings, view, lights, *size, voxel.into(), &spheres, &grouping)
    }
}

/// What frames leave is the same whatever scratch memory held before each; `frames` makes them, and fills it with a word if one is given.
pub fn unaffected_by_poison(name: &str, frames: impl Fn(Option<u32>) -> Option<Vec<Bits>>) {
    let Some(clean) = frames(None) else { return };
    for word in POISONS {
        let poisoned = frames(Some(word)).expect("a device");
        for (number, (clean, poisoned)) in clean.iter().zip(&poisoned).enumerate() {
            let differing = clean.differences(poisoned);
            assert!(differing.is_empty(), "{name}, {word:#x}, frame {number}: {differing:?}");
        }
    }
}
