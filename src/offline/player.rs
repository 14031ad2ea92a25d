//! Effects as the offline host drives them, whichever they are: each says how a scene becomes a frame of its own.

use std::any::Any;
use std::fmt;

use ash::vk;

use super::Scene;
use super::past::Past;
use crate::effect::{Effect, Effort, Kind};
use crate::error::Result;
use crate::gpu::executor::Executor;
use crate::gpu::headless::Headless;
use crate::gpu::profiler::Timing;
use crate::gpu::recorder::Stream;
use crate::host::{Background, DepthFormat, Host, HostBuffer, HostImage, MemorySource, TemporalImages};
use crate::plan::BufferId;

/// Description of an effect, and how it is fed.
pub trait Describe: Clone + fmt::Debug + 'static {
    /// How a scene becomes a frame of the effect.
    type Feed: Feed<Kind: Kind<Desc = Self>>;
    /// Its use of depth.
    const DEPTH: Depth;

    /// Width and height of the picture.
    fn size(&self) -> [u32; 2];

    /// Whether it needs a depth image whatever else is drawn.
    fn wants_depth(&self) -> bool {
        false
    }

    /// Takes part in the depth and the motion vectors that effects share.
    fn share(&mut self, _: Sharing) {}

    /// Takes no more memory than this device should give.
    #[must_use]
    fn fitted(self, _: &Host) -> Self {
        self
    }
}

/// An effect's use of the depth of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Nothing.
    None,
    /// It is hidden by what is in front of it.
    Hidden,
    /// It is, and leaves its own depth in a buffer.
    Leaves,
    /// It is solid: what is behind it is hidden.
    Solid,
}

/// What effects of a picture share.
#[derive(Clone, Copy, Debug)]
pub struct Sharing {
    /// There is an image, which all of them test and write.
    pub image: Option<DepthFormat>,
    /// There is none, and an effect before this one leaves its depth in a buffer.
    pub buffer: bool,
    /// Format of motion vectors, if they write such.
    pub vectors: Option<vk::Format>,
}

/// Results of effects for those that are drawn after them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Left {
    /// A surface where it covers pixels in part.
    pub edges: Option<HostBuffer>,
    /// View depth of each pixel in metres.
    pub depth: Option<HostBuffer>,
}

/// Where an effect is drawn in a frame.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The picture; none where nothing is drawn.
    pub target: Option<HostImage>,
    /// The background of the first effect, or [`Background::Keep`].
    pub background: Background,
    /// The shared depth image.
    pub depth: Option<HostImage>,
    /// That of motion vectors.
    pub vectors: Option<HostImage>,
    /// By the effects before it.
    pub left: Left,
}

impl Place {
    /// Outputs beside the picture, of an effect that does not know what the frame before was seen through.
    pub fn temporal(&self, scene: &Scene) -> TemporalImages {
        let motion = self.target.and(self.vectors);
        TemporalImages { motion, reactive: None, previous: motion.and(scene.previous) }
    }
}

/// Carries what scenes bring to the device, and says it as frames of one effect.
pub trait Feed: Default + 'static {
    /// The effect.
    type Kind: Kind;
    /// Whether it moves on in frames that are not drawn.
    const MOVES: bool = false;

    /// Uploads what the scene brings. Every frame before has been waited for.
    ///
    /// # Errors
    /// Something is missing; no memory; a failed Vulkan call.
    fn upload(&mut self, _: &Effect<Self::Kind>, _: &mut Headless, _: &Scene, _: &Place) -> Result<()> {
        Ok(())
    }

    /// The frame; none where there is nothing to draw on.
    fn frame<'a>(
        &'a self,
        effect: &Effect<Self::Kind>,
        scene: &Scene<'a>,
        place: &Place,
    ) -> Option<<Self::Kind as Kind>::Frame<'a>>;

    /// Checks a frame before others are recorded, which would not know that it is never submitted.
    ///
    /// # Errors
    /// The effect would refuse it.
    fn check(_: &Effect<Self::Kind>, _: &<Self::Kind as Kind>::Frame<'_>) -> Result<()> {
        Ok(())
    }

    /// Notes what the effect leaves for those after it.
    fn leave(_: &Effect<Self::Kind>, _: &mut Left) {}

    /// Notes that the frame has been waited for.
    fn finished(&mut self) {}

    /// Destroys what carries scenes.
    ///
    /// # Safety
    /// The device is done with every frame; `host` and `allocator` are those that everything was made with.
    unsafe fn destroy(&mut self, _: &Host, _: &mut dyn MemorySource) {}
}

/// An effect and its [`Feed`].
pub(crate) trait Player {
    fn executor(&self) -> &Executor;
    fn executor_mut(&mut self) -> &mut Executor;
    /// As an [`Effect`].
    fn effect_mut(&mut self) -> &mut dyn Any;
    /// Whether it has anything to do in a frame that is not drawn.
    fn moves(&self) -> bool;
    /// As [`Feed::upload`].
    fn upload(&mut self, device: &mut Headless, scene: &Scene, place: &Place) -> Result<()>;
    /// As [`Feed::check`].
    fn check(&self, scene: &Scene, place: &Place) -> Result<()>;
    /// As [`Feed::leave`].
    fn leave(&self, left: &mut Left);
    /// Records the frame.
    ///
    /// # Safety
    /// As [`Effect::record`]; the scene was uploaded last.
    unsafe fn record(
        &mut self,
        host: &Host,
        stream: &mut dyn Stream,
        scene: &Scene,
        place: &Place,
        timing: &mut Timing,
    ) -> Result<()>;
    /// As [`Feed::finished`].
    fn finished(&mut self);
    /// What the next frame goes on from; none if it does not.
    fn past(&self) -> Option<Past>;
    /// As [`Effect::go_on_from`].
    fn go_on_from(&mut self, words: &[u32]);
    /// Destroys all of it.
    ///
    /// # Safety
    /// As [`Effect::destroy`].
    unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource);
}

struct Fed<F: Feed> {
    effect: Effect<F::Kind>,
    feed: F,
}

impl<F: Feed<Kind: 'static>> Player for Fed<F> {
    fn executor(&self) -> &Executor {
        self.effect.executor()
    }

    fn executor_mut(&mut self) -> &mut Executor {
        self.effect.executor_mut()
    }

    fn effect_mut(&mut self) -> &mut dyn Any {
        &mut self.effect
    }

    fn moves(&self) -> bool {
        F::MOVES
    }

    fn upload(&mut self, device: &mut Headless, scene: &Scene, place: &Place) -> Result<()> {
        self.feed.upload(&self.effect, device, scene, place)
    }

    fn check(&self, scene: &Scene, place: &Place) -> Result<()> {
        self.feed.frame(&self.effect, scene, place).map_or(Ok(()), |frame| F::check(&self.effect, &frame))
    }

    fn leave(&self, left: &mut Left) {
        F::leave(&self.effect, left);
    }

    unsafe fn record(
        &mut self,
        host: &Host,
        stream: &mut dyn Stream,
        scene: &Scene,
        place: &Place,
        timing: &mut Timing,
    ) -> Result<()> {
        let Fed { effect, feed } = self;
        match feed.frame(effect, scene, place) {
            // SAFETY: the caller's.
            Some(frame) => unsafe { effect.record_into(host, stream, &frame, timing) },
            None => Ok(()),
        }
    }

    fn finished(&mut self) {
        self.feed.finished();
    }

    fn past(&self) -> Option<Past> {
        self.effect.past()
    }

    fn go_on_from(&mut self, words: &[u32]) {
        self.effect.go_on_from(words);
    }

    unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's.
        unsafe {
            self.effect.destroy(host, allocator);
            self.feed.destroy(host, allocator);
        }
    }
}

/// Makes an effect.
///
/// # Errors
/// As [`Effect::new`].
pub(crate) fn make<D: Describe>(device: &mut Headless, desc: D, effort: Effort) -> Result<Box<dyn Player>> {
    let (host, kernels, allocator) = device.making();
    // SAFETY: the device's own handles.
    let effect = unsafe { Effect::with_effort(&host, kernels, allocator, desc.fitted(&host), effort)? };
    Ok(Box::new(Fed::<D::Feed> { effect, feed: D::Feed::default() }))
}

/// A buffer of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EffectBuffer {
    /// The effect's name.
    pub effect: &'static str,
    /// Of its layout.
    pub id: BufferId,
}

impl EffectBuffer {
    /// A buffer of that kind of effect.
    pub const fn of<K: Kind>(id: BufferId) -> EffectBuffer {
        EffectBuffer { effect: K::NAME, id }
    }
}
