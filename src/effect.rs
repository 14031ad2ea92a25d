//! An effect on the device, and where its parts are.
//!
//! All effects are divided alike:
//!
//! | file | holds |
//! |---|---|
//! | `desc.rs` | what an effect is made for |
//! | `settings.rs` | the look: one field a key of the shot's table |
//! | `frame.rs` | what a host says of one frame |
//! | `limits.rs` | how much there may be of everything, and how work is cut into dispatches |
//! | `layout.rs` | its buffers and images, and how large they are |
//! | `params.rs` | what its kernels are told |
//! | `passes.rs` | its passes, each declared once |
//! | `steps.rs` | which passes a frame takes, in which order, and why others are left out |
//! | `mod.rs` | its [`Kind`]: how these make an [`Effect`] |
//!
//! A setting becomes a pass in `steps.rs`, which fills a [`Plan`]; [`crate::low_level::barrier`] derives the barriers between its
//! steps from what `passes.rs` and the shaders declare; [`crate::low_level::gpu::recorder`] walks the list into a command buffer.

mod inventory;

use std::fmt;

use ash::vk;

use crate::error::{Error, Result};
pub use crate::gpu::capabilities::DeviceTraits;
use crate::gpu::debug;
use crate::gpu::executor::{Description, Executor};
pub use crate::gpu::executor::{Retired, StepParts};
pub use crate::gpu::kernels::Kernels;
use crate::gpu::profiler::{Mode, Timing};
use crate::gpu::recorder::Stream;
use crate::gpu::resources::{Kept, Resources};
use crate::gpu::scratch::Shared;
pub use crate::gpu::scratch::{ScratchNeeds, ScratchPool, ScratchRange};
use crate::host::{Host, Memory, MemorySource, NamedFormat, check_formats};
use crate::plan::{BufferId, ImageId, Pass, Plan, most_steps};
pub use inventory::Inventory;

/// How much of a frame's work is done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// The work that the frame needs.
    #[default]
    Needed,
    /// All of it: only to prove that leaving work out changes nothing.
    Everything,
    /// The work that the frame needs, and nothing lies where something else has lain: parts of a frame can run once more.
    Repeatable,
}

impl Effort {
    /// Whether work that a frame does not need is left out.
    pub fn skips(self) -> bool {
        self != Effort::Everything
    }
}

/// The parts that are an effect's own; all else is [`Effect`]'s.
pub trait Kind: fmt::Debug + Sized {
    /// Its name: of its folders, its table in a shot, and before the dot of its passes.
    const NAME: &'static str;
    /// Description of the effect, fixed until it is changed or resized.
    type Desc: Clone + fmt::Debug;
    /// Which buffers and images it has.
    type Layout: Inventory<Desc = Self::Desc>;
    /// A host's description of one frame.
    type Frame<'a>;
    /// The state that is kept of a frame once it has been recorded.
    type Recorded: fmt::Debug;

    /// Checks what it is made for and computes sizes. Pure.
    ///
    /// # Errors
    /// A setting out of range; something larger than a limit.
    fn new(desc: &Self::Desc, traits: &DeviceTraits, effort: Effort) -> Result<Self>;

    /// The same for a picture of another size.
    fn resized(desc: &Self::Desc, size: [u32; 2]) -> Self::Desc;

    /// Its buffers and images.
    fn layout(&self) -> &Self::Layout;

    /// Takes its list of passes, once.
    fn take_passes(&mut self) -> Vec<Pass>;

    /// Fills the cleared plan with a frame's steps. Allocates nothing.
    ///
    /// # Errors
    /// The frame does not fit what the effect was made for.
    fn plan(&mut self, desc: &Self::Desc, frame: &Self::Frame<'_>, plan: &mut Plan) -> Result<Self::Recorded>;

    /// Hands over what the frame brings: the host's buffers and images.
    fn upload(&self, desc: &Self::Desc, frame: &Self::Frame<'_>, resources: &mut Resources);

    /// Notes that a planned frame has been recorded.
    fn recorded(&mut self, desc: &Self::Desc, recorded: Self::Recorded);

    /// Whether a frame begins anew, and so needs nothing that the device holds.
    fn restarts(_: &Self::Frame<'_>) -> bool {
        false
    }

    /// Forgets all frames: the next is as the first.
    fn forget(&mut self);

    /// Goes on from `old`, whose buffers and images are `kept` in part: what this frame needs of earlier ones, if that is there.
    /// `descs` are of `old` and of this.
    fn go_on(&mut self, old: &Self, descs: [&Self::Desc; 2], kept: &Kept);

    /// Buffers that the next frame goes on from, if it brings all that a first one does.
    const PAST: &'static [BufferId] = &[];

    /// What else it goes on from.
    fn past(&self) -> Vec<u32> {
        Vec::new()
    }

    /// Goes on from [`Self::past`]; the buffers hold what they held then.
    fn go_on_from(&mut self, _: &[u32]) {}

    /// The formats of the host's images, and what they are used as.
    fn formats(desc: &Self::Desc) -> Vec<NamedFormat>;
}

fn not_prepared() -> Error {
    Error::HostResource { name: "frame", why: "none is prepared".to_owned() }
}

/// Passes of a kind, and what they name.
pub fn describe<K: Kind>(kind: &mut K, desc: &K::Desc, effort: Effort) -> Description {
    Description {
        name: K::NAME,
        passes: kind.take_passes(),
        buffers: kind.layout().buffers(desc),
        host_buffers: K::Layout::HOST_BUFFERS,
        images: kind.layout().images(desc),
        host_images: K::Layout::HOST_IMAGES,
        bound: kind.layout().bound(desc),
        overlays: if effort == Effort::Needed { kind.layout().overlays(desc) } else { Vec::new() },
        memory: kind.layout().memory(desc),
    }
}

/// An effect on a device: pipelines, and the buffers and images of one picture size.
///
/// Its state lives on the device and moves on with each recorded frame, so every recorded command buffer must be
/// submitted, in order, to the same queue. A frame may be recorded before the one before it has finished.
#[derive(Debug)]
pub struct Effect<K: Kind> {
    desc: K::Desc,
    effort: Effort,
    kind: K,
    executor: Executor,
    prepared: Option<Prepared<K::Recorded>>,
}

/// A frame that has been planned and not yet recorded to its end.
#[derive(Debug)]
struct Prepared<R> {
    recorded: R,
    restarts: bool,
    /// The step that is recorded next.
    next: usize,
}

impl<K: Kind> Effect<K> {
    /// Device memory that an effect will take on a device with these traits, before alignment.
    ///
    /// # Errors
    /// A setting out of range, or something too large for the device.
    pub fn memory(desc: &K::Desc, traits: &DeviceTraits) -> Result<Memory> {
        Ok(K::new(desc, traits, Effort::Needed)?.layout().memory(desc))
    }

    /// Creates buffers and images, and pipelines that `kernels` has not got yet; but for those it leaves nothing behind on
    /// error.
    ///
    /// # Errors
    /// A setting out of range, something too large for the device, no memory, a failed Vulkan call.
    ///
    /// # Safety
    /// `host` holds valid handles of a device that [`crate::host::requirements`] are enabled on; `allocator` and `kernels`
    /// are that device's. `kernels` is destroyed after the effect.
    pub unsafe fn new(
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        desc: K::Desc,
    ) -> Result<Effect<K>> {
        // SAFETY: the caller's.
        unsafe { Self::with_effort(host, kernels, allocator, desc, Effort::Needed) }
    }

    /// [`Self::new`], to prove that leaving work out changes nothing.
    ///
    /// # Errors
    /// As there.
    ///
    /// # Safety
    /// As there.
    #[doc(hidden)]
    pub unsafe fn with_effort(
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        desc: K::Desc,
        effort: Effort,
    ) -> Result<Effect<K>> {
        // SAFETY: the caller's.
        unsafe { Self::make(host, kernels, allocator, desc, effort, None) }
    }

    /// [`Self::new`] in scratch memory that other effects may use, too. Frames of effects in one pool are recorded one after the
    /// other, each to its end, and submitted in that order. What [`Self::buffer`] returns holds until one of another is.
    ///
    /// # Errors
    /// As there; the pool is too small, and how large it has to be.
    ///
    /// # Safety
    /// As there; `pool` is of the same device, and destroyed after the effect.
    pub unsafe fn new_in(
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        desc: K::Desc,
        pool: &ScratchPool,
    ) -> Result<Effect<K>> {
        // SAFETY: the caller's.
        unsafe { Self::make(host, kernels, allocator, desc, Effort::Needed, Some(pool)) }
    }

    /// What scratch memory must be for an effect of this description. Objects are made to ask the device, and destroyed; no memory is
    /// taken.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// # Safety
    /// As [`Self::new`].
    pub unsafe fn scratch_needs(
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        desc: &K::Desc,
    ) -> Result<ScratchNeeds> {
        // SAFETY: the caller's.
        unsafe {
            let (_, description) = Self::describe(host, kernels, desc, Effort::Needed)?;
            Executor::scratch_needs(host, allocator, &description)
        }
    }

    unsafe fn make(
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        desc: K::Desc,
        effort: Effort,
        pool: Option<&ScratchPool>,
    ) -> Result<Effect<K>> {
        // SAFETY: the caller's.
        unsafe {
            let (kind, description) = Self::describe(host, kernels, &desc, effort)?;
            let executor = Executor::new(host, kernels, allocator, description, pool)?;
            Ok(Effect { desc, effort, kind, executor, prepared: None })
        }
    }

    /// All of an effect that needs no memory.
    unsafe fn describe(host: &Host, kernels: &Kernels, desc: &K::Desc, effort: Effort) -> Result<(K, Description)> {
        // SAFETY: the caller's.
        unsafe {
            let mut kind = K::new(desc, &kernels.traits(host), effort)?;
            check_formats(host, &K::formats(desc))?;
            debug::check(host)?;
            let description = describe(&mut kind, desc, effort);
            Ok((kind, description))
        }
    }

    /// Makes the pipelines that an effect of this description takes, and nothing else: on any thread, before it is needed.
    /// [`Self::new`] then takes milliseconds.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// # Safety
    /// As [`Self::new`].
    pub unsafe fn compile(host: &Host, kernels: &Kernels, desc: &K::Desc) -> Result<()> {
        // SAFETY: the caller's.
        unsafe {
            let (_, description) = Self::describe(host, kernels, desc, Effort::Needed)?;
            kernels.make(host, &description.passes)
        }
    }

    /// Changes what the effect was made for: the look, the size of the picture, anything. Buffers that stay the same keep
    /// what they hold, and the sequence goes on, unless what it needs has another size: then the next frame must bring all that
    /// a first one does, and is refused if it does not. On error the effect is as it was. In a [`ScratchPool`] it needs no more than that
    /// has: [`Self::scratch_needs`] of the new description says it before, and [`Self::change_in`] takes a larger one.
    ///
    /// It waits for nothing: objects that are replaced are handed back, to be destroyed when the GPU is done with the frames
    /// recorded so far. To hold old and new memory never at once, [`Self::retire`] the effect and make a new one.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// # Safety
    /// As [`Self::new`], with the same `host`, `kernels` and `allocator`.
    pub unsafe fn change(
        &mut self,
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        desc: K::Desc,
    ) -> Result<Retired> {
        // SAFETY: the caller's.
        unsafe { self.change_to(host, kernels, allocator, desc, self.executor.pool()) }
    }

    /// [`Self::change`], with scratch memory in this pool from now on, which may be a larger one.
    ///
    /// # Errors
    /// As [`Self::new_in`].
    ///
    /// # Safety
    /// As [`Self::change`] and [`Self::new_in`]. The pool before is destroyed after what is handed back.
    pub unsafe fn change_in(
        &mut self,
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        desc: K::Desc,
        pool: &ScratchPool,
    ) -> Result<Retired> {
        // SAFETY: the caller's.
        unsafe { self.change_to(host, kernels, allocator, desc, Some(pool.shared())) }
    }

    unsafe fn change_to(
        &mut self,
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        desc: K::Desc,
        pool: Option<Shared>,
    ) -> Result<Retired> {
        // SAFETY: the caller's.
        let (mut kind, description) = unsafe { Self::describe(host, kernels, &desc, self.effort)? };
        self.drop_parts();
        // SAFETY: the caller's.
        let (retired, kept) = unsafe { self.executor.change_to(host, kernels, allocator, description, pool)? };
        kind.go_on(&self.kind, [&self.desc, &desc], &kept);
        (self.kind, self.desc, self.prepared) = (kind, desc, None);
        Ok(retired)
    }

    /// [`Self::change`] of the size of the picture alone.
    ///
    /// # Errors
    /// As there.
    ///
    /// # Safety
    /// As there.
    pub unsafe fn resize(
        &mut self,
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        size: [u32; 2],
    ) -> Result<Retired> {
        // SAFETY: the caller's.
        unsafe { self.change(host, kernels, allocator, K::resized(&self.desc, size)) }
    }

    /// Ends the effect: its objects, to be destroyed when the GPU is done with the frames recorded so far.
    pub fn retire(self) -> Retired {
        self.executor.retire()
    }

    /// Records a frame. Allocates nothing, submits nothing, waits for nothing.
    ///
    /// # Errors
    /// The frame does not fit what the effect was made for; nothing has been recorded then.
    ///
    /// # Safety
    /// `host` is the one the effect was made with. `commands` is in recording state, outside of a render pass, of a queue
    /// family with graphics and compute. Host images and buffers are in the states that they declare, and hold what the
    /// frame says of them. The frame is submitted after all frames recorded before it, to the same queue.
    pub unsafe fn record(
        &mut self,
        host: &Host,
        mut commands: vk::CommandBuffer,
        frame: &K::Frame<'_>,
        timing: &mut Timing,
    ) -> Result<()> {
        // SAFETY: the caller's.
        unsafe { self.record_into(host, &mut commands, frame, timing) }
    }

    /// [`Self::record`] into the command buffers of a stream.
    ///
    /// # Errors
    /// As there, and what the stream says: the frame is recorded in part then.
    ///
    /// # Safety
    /// As there, for each command buffer.
    pub(crate) unsafe fn record_into(
        &mut self,
        host: &Host,
        stream: &mut dyn Stream,
        frame: &K::Frame<'_>,
        timing: &mut Timing,
    ) -> Result<()> {
        self.prepare(frame)?;
        // SAFETY: the caller's.
        unsafe { self.record_prepared(host, stream, usize::MAX, timing) }.map(drop)
    }

    /// Checks a frame and fills its plan, which [`Self::record_steps`] records. It calls nothing of Vulkan and allocates
    /// nothing. A frame that was prepared before and not recorded is forgotten; one that was recorded in part is dropped
    /// ([`Self::frame_dropped`]).
    ///
    /// # Errors
    /// The frame does not fit what the effect was made for; the effect is as it was, and its plan is empty.
    pub fn prepare(&mut self, frame: &K::Frame<'_>) -> Result<&Plan> {
        self.drop_parts();
        let Effect { desc, kind, executor, prepared, .. } = self;
        *prepared = None;
        executor.plan_mut().clear();
        let recorded = kind.plan(desc, frame, executor.plan_mut())?;
        kind.upload(desc, frame, executor.resources_mut());
        executor.check().inspect_err(|_| executor.plan_mut().clear())?;
        *prepared = Some(Prepared { recorded, restarts: K::restarts(frame), next: 0 });
        Ok(executor.plan())
    }

    /// A frame that is recorded in part does not come to its end.
    fn drop_parts(&mut self) {
        if self.prepared.as_ref().is_some_and(|prepared| prepared.next > 0) {
            self.frame_dropped();
        }
    }

    /// Records the next steps of the prepared frame, at most so many; how many are left. The host's own commands may stand
    /// between, and steps may go to several command buffers that are submitted in order. It is called until none are left, at
    /// least once.
    ///
    /// # Errors
    /// No frame is prepared; too few queries. Nothing has been recorded then.
    ///
    /// # Safety
    /// As [`Self::record`], for the frame that was prepared. What the host records between touches nothing that the frame
    /// names.
    pub unsafe fn record_steps(
        &mut self,
        host: &Host,
        mut commands: vk::CommandBuffer,
        steps: usize,
        timing: &mut Timing,
    ) -> Result<usize> {
        // SAFETY: the caller's.
        unsafe { self.record_prepared(host, &mut commands, steps, timing) }
    }

    unsafe fn record_prepared(
        &mut self,
        host: &Host,
        stream: &mut dyn Stream,
        steps: usize,
        timing: &mut Timing,
    ) -> Result<usize> {
        let Effect { desc, kind, executor, prepared, .. } = self;
        let Some(Prepared { restarts, next, .. }) = prepared else {
            return Err(not_prepared());
        };
        let all = executor.plan().steps.len();
        let range = *next..next.saturating_add(steps).min(all);
        if range.is_empty() && all > 0 {
            return Ok(all - range.end);
        }
        if range.start == 0 {
            timing.check(all as u32)?;
            if *restarts {
                executor.forget();
            }
        }
        *next = range.end;
        // SAFETY: the caller's.
        unsafe { executor.record(host, stream, range.clone(), timing)? };
        if range.end == all
            && let Some(Prepared { recorded, .. }) = prepared.take()
        {
            kind.recorded(desc, recorded);
        }
        Ok(all - range.end)
    }

    /// Says that the frame recorded last is never submitted, as when a swapchain was out of date. What the effect had on the
    /// device before it is not told apart from what that frame would have left, so the next frame must bring all that a
    /// first one does. Frames that were submitted before may still run.
    pub fn frame_dropped(&mut self) {
        self.kind.forget();
        self.executor.forget();
        self.prepared = None;
    }

    /// A step of the prepared plan as Vulkan has it, for hosts that record plans themselves (see [`Self::recorded`]); none beyond
    /// the last. What the step uses stands in its pass.
    pub fn step(&self, index: usize) -> Option<StepParts<'_>> {
        self.executor.step(index)
    }

    /// An image that plans name, and the levels and layers of it that they touch. The effect's own are in layout `GENERAL` in
    /// every step, and begin in `UNDEFINED` where [`Self::is_new`] says so.
    pub fn image(&self, id: ImageId) -> (vk::Image, vk::ImageSubresourceRange) {
        self.executor.image(id)
    }

    /// The view of an image that a render pass attaches: of one layer.
    pub fn attachment(&self, id: ImageId, layer: u32) -> vk::ImageView {
        self.executor.attachment(id, layer)
    }

    /// Whether a frame begins without what an own image holds: it has not been used yet, or is in scratch memory.
    pub fn is_new(&self, id: ImageId) -> bool {
        self.executor.is_new(id)
    }

    /// Says that the host has recorded all steps of the prepared frame by itself, in their order: own images are in layout
    /// `GENERAL` afterwards, and the sequence goes on.
    ///
    /// # Errors
    /// No frame is prepared.
    pub fn recorded(&mut self) -> Result<()> {
        let Some(Prepared { recorded, .. }) = self.prepared.take() else { return Err(not_prepared()) };
        self.executor.keep_images();
        self.kind.recorded(&self.desc, recorded);
        Ok(())
    }

    /// What the next frame goes on from, besides what it brings: words, and what is in buffers; none if it does not.
    #[cfg(feature = "cli")]
    pub(crate) fn past(&self) -> Option<(Vec<u32>, &'static [BufferId])> {
        (!K::PAST.is_empty()).then(|| (self.kind.past(), K::PAST))
    }

    /// Goes on from these words, once the buffers hold what belongs to them.
    #[cfg(feature = "cli")]
    pub(crate) fn go_on_from(&mut self, words: &[u32]) {
        self.kind.go_on_from(words);
    }

    /// The effect's parts on the device.
    #[cfg(feature = "cli")]
    pub(crate) fn executor(&self) -> &Executor {
        &self.executor
    }

    #[cfg(feature = "cli")]
    pub(crate) fn executor_mut(&mut self) -> &mut Executor {
        &mut self.executor
    }

    /// Whether steps overlap (default) or are isolated by full barriers, for comparing kernels.
    pub fn set_mode(&mut self, mode: Mode) {
        self.executor.set_mode(mode);
    }

    /// The description that the effect was made for.
    pub fn desc(&self) -> &K::Desc {
        &self.desc
    }

    /// The most steps that a frame can have, until the effect is changed: with [`crate::profile::queries`], as many timestamps as
    /// [`Timing::Queries`] needs room for.
    pub fn most_steps(&self) -> u32 {
        most_steps(self.executor.passes()) as u32
    }

    /// The list of the frame prepared or recorded last; empty after one that was refused.
    pub fn plan(&self) -> &Plan {
        self.executor.plan()
    }

    /// The declared passes, which the plan's steps refer to.
    pub fn passes(&self) -> &[Pass] {
        self.executor.passes()
    }

    /// The passes that the frame recorded last left out: each one's name, and why.
    pub fn skipped(&self) -> impl Iterator<Item = (&'static str, &'static str)> + '_ {
        self.executor.skipped()
    }

    /// Where all is that frames begin without, for a host that puts other things there between frames; none if there is nothing.
    pub fn scratch(&self) -> Option<ScratchRange> {
        self.executor.scratch()
    }

    /// A buffer of the effect, to be read after a frame: handle, offset and size in bytes. The ids stand in the effect's
    /// `layout`. The last access to it was a shader's or a transfer's write.
    pub fn buffer(&self, id: BufferId) -> (vk::Buffer, u64, u64) {
        self.executor.buffer(id)
    }

    /// Destroys what celfx made.
    ///
    /// # Safety
    /// The GPU is done with every recorded frame; `host` and `allocator` are those it was made with. Nothing else is called
    /// afterwards.
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's.
        unsafe { self.executor.destroy(host, allocator) };
    }
}
