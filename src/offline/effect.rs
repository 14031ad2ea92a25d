//! What effects have in common once they are made.

use ash::vk;
use gpu_allocator::vulkan::Allocator;

use crate::blur;
use crate::effect::{Effect, Kind};
use crate::error::{Error, Result};
use crate::flame;
use crate::gpu::profiler::Mode;
use crate::host::{Host, Memory};
use crate::plan::{BufferId, Pass, Plan};
use crate::smoke;

/// What effects are made for: at least one, all of one picture size.
#[derive(Clone, Debug, Default)]
pub struct Effects {
    /// The smoke.
    pub smoke: Option<smoke::Desc>,
    /// The flame. With smoke or blur its scene is their depth, whatever this says.
    pub flame: Option<flame::Desc>,
    /// The blur, which is drawn first; the others are behind its mesh and before it. `frames_resident` is how many
    /// frames' poses outputs are made of.
    pub blur: Option<blur::Desc>,
}

impl From<smoke::Desc> for Effects {
    fn from(desc: smoke::Desc) -> Effects {
        Effects { smoke: Some(desc), ..Effects::default() }
    }
}

impl From<flame::Desc> for Effects {
    fn from(desc: flame::Desc) -> Effects {
        Effects { flame: Some(desc), ..Effects::default() }
    }
}

impl From<blur::Desc> for Effects {
    fn from(desc: blur::Desc) -> Effects {
        Effects { blur: Some(desc), ..Effects::default() }
    }
}

impl Effects {
    /// The size of the picture that all of them make.
    pub(super) fn size(&self) -> Result<[u32; 2]> {
        let sizes = [
            ("smoke", self.smoke.as_ref().map(|desc| desc.size)),
            ("flame", self.flame.as_ref().map(|desc| desc.size)),
            ("blur", self.blur.as_ref().map(|desc| desc.size)),
        ];
        let mut sizes = sizes.into_iter().filter_map(|(name, size)| Some((name, size?)));
        let refuse = |why: String| Err(Error::HostResource { name: "effects", why });
        let Some((first, size)) = sizes.next() else { return refuse("none; expected at least one".to_owned()) };
        match sizes.find(|(_, other)| *other != size) {
            Some((name, other)) => {
                refuse(format!("{first} of {size:?} pixels, {name} of {other:?}; expected one size"))
            }
            None => Ok(size),
        }
    }
}

/// A buffer of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectBuffer {
    /// Of [`smoke::layout`].
    Smoke(BufferId),
    /// Of [`flame::layout`].
    Flame(BufferId),
    /// Of [`blur::layout`].
    Blur(BufferId),
}

/// An effect that has been made, whatever its kind.
pub(crate) trait AnyEffect {
    /// As [`Effect::memory`].
    fn memory(&self) -> Memory;
    /// As [`Effect::set_mode`].
    fn set_mode(&mut self, mode: Mode);
    /// As [`Effect::plan`].
    fn plan(&self) -> &Plan;
    /// As [`Effect::passes`].
    fn passes(&self) -> &[Pass];
    /// As [`Effect::buffer`].
    fn buffer(&self, id: BufferId) -> (vk::Buffer, u64, u64);
    /// As [`Effect::replay`].
    ///
    /// # Safety
    /// As there.
    unsafe fn replay(&mut self, host: &Host, commands: vk::CommandBuffer, plan: &Plan) -> Result<()>;
    /// As [`Effect::destroy`].
    ///
    /// # Safety
    /// As there.
    unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator);
}

impl<K: Kind> AnyEffect for Effect<K> {
    fn memory(&self) -> Memory {
        Effect::<K>::memory(self.desc(), u64::MAX).unwrap_or_default()
    }

    fn set_mode(&mut self, mode: Mode) {
        self.set_mode(mode);
    }

    fn plan(&self) -> &Plan {
        self.plan()
    }

    fn passes(&self) -> &[Pass] {
        self.passes()
    }

    fn buffer(&self, id: BufferId) -> (vk::Buffer, u64, u64) {
        self.buffer(id)
    }

    unsafe fn replay(&mut self, host: &Host, commands: vk::CommandBuffer, plan: &Plan) -> Result<()> {
        // SAFETY: the caller's.
        unsafe { self.replay(host, commands, plan) }
    }

    unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        // SAFETY: the caller's.
        unsafe { self.destroy(host, allocator) };
    }
}
