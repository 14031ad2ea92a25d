//! A list of passes on the device: buffers and images, pipelines, and the recorder that walks plans of them.

use std::ops::Range;

use ash::vk;

use crate::barrier::return_to;
use crate::error::Result;
use crate::gpu::buffer::BufferDesc;
use crate::gpu::image::ImageDesc;
use crate::gpu::kernels::{Kernels, Key, push_range};
use crate::gpu::pipelines::Pipelines;
use crate::gpu::profiler::{Mode, Timing};
use crate::gpu::recorder::{Recorder, Recording, Stream, check};
use crate::gpu::resources::{BufferSlot, ImageSlot, Kept, Resources};
use crate::gpu::scratch::{Lifetime, Overlay, ScratchNeeds, ScratchPool, ScratchRange, Shared};
use crate::host::{Host, HostBuffer, Memory, MemorySource};
use crate::plan::{BufferId, ImageId, Pass, Plan, Step};

/// Passes, and what they run with on the device.
#[derive(Debug)]
pub struct Executor {
    passes: Vec<Pass>,
    resources: Resources,
    pipelines: Pipelines,
    recorder: Recorder,
    plan: Plan,
    memory: Memory,
}

/// Passes, and what they name: own buffers and images in the order of their ids, then those that the host hands over.
#[derive(Debug)]
pub struct Description {
    /// The effect's name.
    pub name: &'static str,
    /// By [`crate::plan::PassId`].
    pub passes: Vec<Pass>,
    /// Own buffers.
    pub buffers: Vec<BufferDesc>,
    /// How many buffers the host hands over.
    pub host_buffers: usize,
    /// Own images.
    pub images: Vec<ImageDesc>,
    /// How many images the host hands over.
    pub host_images: usize,
    /// Those of the host's buffers that stay the same.
    pub bound: Vec<(BufferId, HostBuffer)>,
    /// What of those lies in the same place.
    pub overlays: Vec<Overlay>,
    /// Of own buffers and images, before alignment.
    pub memory: Memory,
}

impl Executor {
    /// Creates everything, scratch in the pool if there is one; leaves nothing behind on error.
    ///
    /// # Errors
    /// No memory, a pool that is too small, a pass that binds nothing to one of its bindings, a failed Vulkan call.
    ///
    /// # Safety
    /// `host` holds valid handles; `kernels`, which outlives the result, and `allocator` belong to its device.
    pub unsafe fn new(
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        description: Description,
        pool: Option<&ScratchPool>,
    ) -> Result<Executor> {
        let pool = pool.map(ScratchPool::shared);
        let mut resources = Resources::default();
        // SAFETY: the caller's; what was made is destroyed unused on error.
        unsafe {
            let kept = Kept::new(&resources, &description.buffers, &description.images, &description.overlays, pool);
            create(host, allocator, &description, &kept, pool, &mut resources)
                .inspect_err(|_| resources.destroy(host, allocator))?;
            let executor = Executor::on(host, kernels, allocator, description.passes, resources)?;
            Ok(Executor { memory: description.memory, ..executor })
        }
    }

    /// What the scratch memory of such an effect must be.
    ///
    /// # Errors
    /// A failed Vulkan call.
    ///
    /// # Safety
    /// `host` holds valid handles.
    pub(crate) unsafe fn scratch_needs(
        host: &Host,
        allocator: &mut dyn MemorySource,
        description: &Description,
    ) -> Result<ScratchNeeds> {
        let mut resources = Resources::default();
        // SAFETY: the caller's; what was made is destroyed unused.
        unsafe {
            let made = create_scratch(host, description, &mut resources);
            let (needs, _) = resources.place(host);
            resources.destroy(host, allocator);
            made.map(|()| needs)
        }
    }

    /// Takes resources that are there, and destroys them on error.
    ///
    /// # Safety
    /// As [`Executor::new`].
    pub(crate) unsafe fn on(
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        passes: Vec<Pass>,
        mut resources: Resources,
    ) -> Result<Executor> {
        // SAFETY: the caller's.
        let pipelines = unsafe {
            Pipelines::new(host, kernels, &passes, &resources).inspect_err(|_| resources.destroy(host, allocator))?
        };
        let (recorder, plan, memory) = (Recorder::new(&resources), Plan::for_passes(&passes), Memory::default());
        Ok(Executor { passes, resources, pipelines, recorder, plan, memory })
    }

    /// Changes to another description of the same kind, or to another pool. Buffers and images whose description stays the same keep what they
    /// hold; what is replaced is handed back. On error everything is as it was.
    ///
    /// # Errors
    /// As [`Executor::new`].
    ///
    /// # Safety
    /// As [`Executor::new`], with the same `host` and `kernels`.
    pub(crate) unsafe fn change_to(
        &mut self,
        host: &Host,
        kernels: &Kernels,
        allocator: &mut dyn MemorySource,
        description: Description,
        pool: Option<Shared>,
    ) -> Result<(Retired, Kept)> {
        let kept = Kept::new(&self.resources, &description.buffers, &description.images, &description.overlays, pool);
        let is_bound =
            |(id, new): &(BufferId, HostBuffer)| self.resources.buffer(*id) == (new.buffer, new.offset, new.size);
        let same = description.bound.iter().all(is_bound) && same_bindings(&self.passes, &description.passes);
        let mut resources = Resources::default();
        // SAFETY: the caller's; what was made is destroyed unused on error.
        let pipelines = unsafe {
            create(host, allocator, &description, &kept, pool, &mut resources)
                .inspect_err(|_| resources.destroy(host, allocator))?;
            kept.exchange(&mut self.resources, &mut resources);
            match kept.is_all() && same {
                true => std::mem::take(&mut self.pipelines),
                false => Pipelines::new(host, kernels, &description.passes, &resources).inspect_err(|_| {
                    kept.exchange(&mut self.resources, &mut resources);
                    resources.destroy(host, allocator);
                })?,
            }
        };
        self.recorder = self.recorder.following(&resources);
        self.plan = Plan::for_passes(&description.passes);
        (self.passes, self.memory) = (description.passes, description.memory);
        let pipelines = std::mem::replace(&mut self.pipelines, pipelines);
        let resources = std::mem::replace(&mut self.resources, resources);
        Ok((Retired { pipelines, resources }, kept))
    }

    /// Its parts, to be destroyed.
    pub(crate) fn retire(self) -> Retired {
        Retired { pipelines: self.pipelines, resources: self.resources }
    }

    /// Changes passes. Plans stay; the mode does not.
    ///
    /// # Errors
    /// As [`Executor::new`].
    ///
    /// # Safety
    /// As [`Executor::new`], with the same `host` and `kernels`; the GPU is done with every recorded plan.
    #[cfg(feature = "cli")]
    pub(crate) unsafe fn change(&mut self, host: &Host, kernels: &Kernels, change: impl Fn(&mut Pass)) -> Result<()> {
        self.passes.iter_mut().for_each(change);
        // SAFETY: the caller's.
        unsafe {
            let pipelines = Pipelines::new(host, kernels, &self.passes, &self.resources)?;
            std::mem::replace(&mut self.pipelines, pipelines).destroy(host);
        }
        self.recorder = Recorder::new(&self.resources);
        Ok(())
    }

    /// The passes, which plans' steps refer to.
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// The resources that plans name, for the host to hand over its own.
    pub fn resources_mut(&mut self) -> &mut Resources {
        &mut self.resources
    }

    /// Whether steps overlap or are isolated by full barriers.
    pub fn set_mode(&mut self, mode: Mode) {
        self.recorder.set_mode(mode);
    }

    /// The plan that is recorded next, or was recorded last.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The plan, to be filled; it has room for all that the passes declare.
    pub fn plan_mut(&mut self) -> &mut Plan {
        &mut self.plan
    }

    /// The passes that the plan left out: each one's name, and why.
    pub fn skipped(&self) -> impl Iterator<Item = (&'static str, &'static str)> + '_ {
        self.plan.skipped.iter().map(|(pass, reason)| (self.passes[usize::from(pass.0)].name, *reason))
    }

    /// The resources that plans name.
    #[cfg(feature = "cli")]
    pub(crate) fn resources(&self) -> &Resources {
        &self.resources
    }

    /// Device memory of own buffers and images, before alignment.
    pub fn memory(&self) -> Memory {
        self.memory
    }

    /// The pool that scratch is in, if it is in one.
    pub(crate) fn pool(&self) -> Option<Shared> {
        self.resources.scratch.as_ref().and_then(|scratch| scratch.shared)
    }

    /// Where scratch is.
    pub(crate) fn scratch(&self) -> Option<ScratchRange> {
        self.resources.scratch.as_ref().map(|scratch| scratch.range)
    }

    /// Refuses the plan if it does not fit the resources.
    ///
    /// # Errors
    /// A copy of more than a host's buffer has.
    pub fn check(&self) -> Result<()> {
        debug_assert_eq!(return_to(&self.plan, &self.passes, &self.resources.overlays), None);
        check(&self.plan, &self.passes, &self.resources)
    }

    /// Forgets what the device holds: images are initialised once more.
    pub fn forget(&mut self) {
        self.resources.forget();
    }

    /// Records steps of the plan, which [`Self::check`] has found nothing wrong with. They come in order, the first and the
    /// last included.
    ///
    /// # Errors
    /// What the stream says.
    ///
    /// # Safety
    /// `host` is the one that everything was made with; the command buffers of `stream` are in recording state, outside of
    /// a render pass; what the host has handed over is in the states that it declared.
    pub unsafe fn record(
        &mut self,
        host: &Host,
        stream: &mut dyn Stream,
        steps: Range<usize>,
        timing: &mut Timing,
    ) -> Result<()> {
        let Executor { passes, resources, pipelines, recorder, plan, .. } = self;
        let mut recording = Recording { host, stream, passes, pipelines, resources };
        // SAFETY: the caller's.
        plan.barriers = unsafe { recorder.record(plan, steps, &mut recording, timing)? };
        Ok(())
    }

    /// Records steps of the plan recorded last once more, to measure them alone. They read what that plan left; none of
    /// them may touch the host's images or buffers, or what later plans go on from.
    ///
    /// # Errors
    /// None: as [`Executor::record`].
    ///
    /// # Safety
    /// As [`Executor::record`].
    #[cfg(feature = "cli")]
    pub unsafe fn replay(&mut self, host: &Host, mut commands: vk::CommandBuffer, plan: &Plan) -> Result<()> {
        self.resources.take_back_images();
        let Executor { passes, resources, pipelines, recorder, .. } = self;
        recorder.keep_scratch();
        let mut recording = Recording { host, stream: &mut commands, passes, pipelines, resources };
        // SAFETY: the caller's.
        unsafe { recorder.record(plan, 0..plan.steps.len(), &mut recording, &mut Timing::None) }.map(drop)
    }

    /// A step of the plan.
    pub(crate) fn step(&self, index: usize) -> Option<StepParts<'_>> {
        let step = self.plan.steps.get(index)?;
        let (pass, bound) = (&self.passes[usize::from(step.pass.0)], self.pipelines.passes[usize::from(step.pass.0)]);
        let (push_stages, size) = push_range(pass);
        let push_constants = &step.constants[..size as usize];
        let (pipeline, layout) = (bound.pipeline.handle, bound.pipeline.layout);
        Some(StepParts { pass, step, pipeline, layout, set: bound.set, push_stages, push_constants })
    }

    /// An image: handle, and what of it plans touch.
    pub(crate) fn image(&self, id: ImageId) -> (vk::Image, vk::ImageSubresourceRange) {
        (self.resources.image(id), self.resources.range(id))
    }

    /// A view of a layer.
    pub(crate) fn attachment(&self, id: ImageId, layer: u32) -> vk::ImageView {
        self.resources.attachment_view(id, layer)
    }

    /// Whether an own image begins the next frame in layout UNDEFINED.
    pub(crate) fn is_new(&self, id: ImageId) -> bool {
        let slot = &self.resources.images[usize::from(id.0)];
        matches!(slot, ImageSlot::Own(image) if !image.initialised || image.is_scratch())
    }

    /// Own images have left layout UNDEFINED.
    pub(crate) fn keep_images(&mut self) {
        for slot in &mut self.resources.images {
            if let ImageSlot::Own(image) = slot {
                image.initialised = true;
            }
        }
    }

    /// A buffer: handle, offset and size in bytes.
    pub fn buffer(&self, id: BufferId) -> (vk::Buffer, u64, u64) {
        self.resources.buffer(id)
    }

    /// Destroys what celfx made.
    ///
    /// # Safety
    /// The GPU is done with every recorded plan; `host` and `allocator` are those it was made with. Nothing else is called
    /// afterwards.
    pub unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's.
        unsafe {
            self.pipelines.destroy(host);
            self.resources.destroy(host, allocator);
        }
    }
}

/// A step as Vulkan has it.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct StepParts<'a> {
    /// Its pass, with name, bindings, attachments and uses.
    pub pass: &'a Pass,
    /// Its command and push constants.
    pub step: &'a Step,
    /// The pipeline; null for transfers, as the layout and the set.
    pub pipeline: vk::Pipeline,
    /// Its layout.
    pub layout: vk::PipelineLayout,
    /// Descriptor set 0.
    pub set: vk::DescriptorSet,
    /// Stages that see the push constants; none if there are none.
    pub push_stages: vk::ShaderStageFlags,
    /// The push constants.
    pub push_constants: &'a [u8],
}

/// Objects that no new frame uses. Frames recorded before may: they are destroyed when the GPU is done with those.
#[derive(Debug)]
#[must_use = "what is not destroyed is lost"]
pub struct Retired {
    pipelines: Pipelines,
    resources: Resources,
}

impl Retired {
    /// Destroys them.
    ///
    /// # Safety
    /// The GPU is done with every frame recorded before they were handed back; `host` and `allocator` are those they were
    /// made with.
    pub unsafe fn destroy(mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's.
        unsafe {
            self.pipelines.destroy(host);
            self.resources.destroy(host, allocator);
        }
    }
}

/// Whether passes take the same pipelines and bind the same.
fn same_bindings(a: &[Pass], b: &[Pass]) -> bool {
    let same = |(a, b): (&Pass, &Pass)| a.bindings == b.bindings && Key::of(a) == Key::of(b);
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// All but what is kept, for which there is an empty place.
unsafe fn create(
    host: &Host,
    allocator: &mut dyn MemorySource,
    description: &Description,
    kept: &Kept,
    pool: Option<Shared>,
    resources: &mut Resources,
) -> Result<()> {
    resources.overlays.clone_from(&description.overlays);
    // SAFETY: the caller's.
    unsafe {
        for (id, buffer) in (0..).zip(&description.buffers) {
            match buffer.lifetime {
                _ if kept.buffer(BufferId(id)) => resources.buffers.push(BufferSlot::Host(None)),
                Lifetime::Scratch | Lifetime::Layer => resources.add_scratch_buffer(host, buffer)?,
                Lifetime::Sequence | Lifetime::Kept => drop(resources.add_buffer(host, allocator, buffer)?),
            }
        }
        for _ in 0..description.host_buffers {
            resources.add_host_buffer();
        }
        for (id, image) in (0..).zip(&description.images) {
            match image.lifetime {
                _ if kept.image(ImageId(id)) => resources.images.push(ImageSlot::Host(None)),
                Lifetime::Scratch | Lifetime::Layer => resources.add_scratch_image(host, image)?,
                Lifetime::Sequence | Lifetime::Kept => drop(resources.add_image(host, allocator, image)?),
            }
        }
        for _ in 0..description.host_images {
            resources.add_host_image();
        }
        description.bound.iter().for_each(|(id, buffer)| resources.set_host_buffer(*id, Some(*buffer)));
        resources.bind_scratch(host, allocator, &format!("{} scratch", description.name), pool)
    }
}

/// What lies in scratch memory, without memory, in its place among others.
unsafe fn create_scratch(host: &Host, description: &Description, resources: &mut Resources) -> Result<()> {
    resources.overlays.clone_from(&description.overlays);
    // SAFETY: the caller's.
    unsafe {
        for buffer in &description.buffers {
            match buffer.lifetime {
                Lifetime::Scratch | Lifetime::Layer => resources.add_scratch_buffer(host, buffer)?,
                Lifetime::Sequence | Lifetime::Kept => drop(resources.add_host_buffer()),
            }
        }
        for image in &description.images {
            match image.lifetime {
                Lifetime::Scratch | Lifetime::Layer => resources.add_scratch_image(host, image)?,
                Lifetime::Sequence | Lifetime::Kept => drop(resources.add_host_image()),
            }
        }
    }
    Ok(())
}
