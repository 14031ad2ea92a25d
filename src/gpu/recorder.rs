//! Walks a plan into a command buffer: barriers, labels, timestamps, commands. Allocates nothing.

use std::ops::Range;

use ash::vk;

use crate::barrier::{Barrier, Change, Tracker, layout};
use crate::error::{Error, Result};
use crate::gpu::debug;
use crate::gpu::kernels::push_range;
use crate::gpu::pipelines::{Bound, Pipelines};
use crate::gpu::profiler::{Mode, Timing};
use crate::gpu::raster::viewport;
use crate::gpu::resources::{BufferSlot, ImageSlot, Resources, range_of};
use crate::host::{Host, HostImage, ImageState};
use crate::plan::{BufferId, Command, ImageId, Kernel, Pass, Plan, Raster, Step, Usage};

/// Records plans of one effect.
#[derive(Debug)]
pub struct Recorder {
    tracker: Tracker,
    mode: Mode,
    /// Whether the next frame comes after ones of other passes, whose stages these may not have.
    follows_others: bool,
    /// Whether the next frame finds in scratch memory what the last one left there.
    keeps_scratch: bool,
    /// Images that change with the barrier to come.
    changing: Vec<vk::ImageMemoryBarrier2<'static>>,
}

/// The command buffers that steps go to: one, or several that are submitted one after the other, to the same queue.
pub trait Stream {
    /// That of a step that comes now, which is named so.
    fn next(&mut self, step: &'static str) -> Result<vk::CommandBuffer>;
    /// That of what was recorded last.
    fn current(&self) -> vk::CommandBuffer;
}

/// All go to this one.
impl Stream for vk::CommandBuffer {
    fn next(&mut self, _: &'static str) -> Result<vk::CommandBuffer> {
        Ok(*self)
    }

    fn current(&self) -> vk::CommandBuffer {
        *self
    }
}

/// The context in which a plan is recorded.
pub struct Recording<'a> {
    /// The host's handles.
    pub host: &'a Host<'a>,
    /// Whose command buffers are in recording state, outside of a render pass.
    pub stream: &'a mut dyn Stream,
    /// The effect's passes.
    pub passes: &'a [Pass],
    /// Their Vulkan side.
    pub pipelines: &'a Pipelines,
    /// The resources that the ids stand for.
    pub resources: &'a mut Resources,
}

impl Recorder {
    /// A recorder for an effect with so many buffers and images.
    pub fn new(resources: &Resources) -> Recorder {
        let tracker = Tracker::new(resources.buffers.len(), resources.images.len()).with_overlays(&resources.overlays);
        Recorder {
            tracker,
            mode: Mode::Overlapping,
            follows_others: false,
            keeps_scratch: false,
            changing: Vec::with_capacity(resources.images.len()),
        }
    }

    /// Whether steps may overlap on the device, or a full barrier isolates each (for comparing kernels).
    pub fn set_mode(&mut self, mode: Mode) {
        self.mode = mode;
    }

    /// A recorder for other resources and passes of the same effect, whose frames come after those of this one.
    pub(crate) fn following(&self, resources: &Resources) -> Recorder {
        Recorder { mode: self.mode, follows_others: true, ..Recorder::new(resources) }
    }

    /// The next frame is a part of the last one, and goes on from what that left in scratch memory.
    #[cfg(feature = "cli")]
    pub(crate) fn keep_scratch(&mut self) {
        self.keeps_scratch = true;
    }

    /// Records steps of `plan`, which come in order; how many barriers all until now took. The frame begins with the first and
    /// ends with the last.
    ///
    /// # Safety
    /// All handles in `recording` are valid, the pipelines and resources were made for its passes, and host resources
    /// that the plan names have been handed over and are in the states that they declare.
    pub unsafe fn record(
        &mut self,
        plan: &Plan,
        steps: Range<usize>,
        recording: &mut Recording,
        timing: &mut Timing,
    ) -> Result<u32> {
        // SAFETY: the caller's, for all of it. Barriers reach over the ends of command buffers.
        unsafe {
            if steps.start == 0 {
                self.open(plan, recording);
            }
            let Recording { host, stream, passes, pipelines, resources } = recording;
            for index in steps.clone() {
                let step = &plan.steps[index];
                let pass = &passes[usize::from(step.pass.0)];
                let commands = stream.next(pass.name)?;
                let derived = self.tracker.before(plan, index, passes);
                let barrier = if self.mode == Mode::Isolated { ISOLATED } else { derived };
                self.barrier(host, commands, resources, &barrier);
                debug::begin_label(host, commands, pass.name);
                timing.begin_scope(host, commands, pass.name);
                let walk = Walk { host, commands, resources, plan };
                walk.step(step, pass, &pipelines.passes[usize::from(step.pass.0)]);
                timing.end_scope(host, commands);
                debug::end_label(host, commands);
            }
            if steps.end < plan.steps.len() {
                return Ok(self.tracker.count());
            }
            for (pass, reason) in &plan.skipped {
                timing.skip(passes[usize::from(pass.0)].name, reason);
            }
            let closing = self.tracker.end(host_images(resources).map(|(id, image)| (id, image.state_out)));
            self.barrier(host, stream.current(), resources, &closing);
        }
        timing.count(plan.steps.len() as u32, self.tracker.count());
        Ok(self.tracker.count())
    }

    /// Orders the frame after the one before it, and takes over what the host hands to it.
    unsafe fn open(&mut self, plan: &Plan, recording: &mut Recording) {
        let Recording { host, stream, passes, resources, .. } = recording;
        self.tracker.begin(plan, passes);
        for slot in &resources.buffers {
            if let BufferSlot::Host(Some(buffer)) = slot {
                self.tracker.take_buffer(buffer.stage, buffer.access);
            }
        }
        host_images(resources).for_each(|(id, image)| self.tracker.take_image(id, image.state_in));
        let is_shared = resources.scratch.as_ref().is_some_and(|scratch| scratch.shared.is_some());
        if std::mem::take(&mut self.follows_others) || is_shared {
            self.tracker.take_buffer(vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
        }
        let keeps_scratch = std::mem::take(&mut self.keeps_scratch);
        // Frames that were recorded before a dropped one may still run.
        let before = ImageState {
            stage: vk::PipelineStageFlags2::ALL_COMMANDS,
            access: vk::AccessFlags2::MEMORY_WRITE,
            layout: vk::ImageLayout::UNDEFINED,
        };
        let all = ImageState {
            stage: vk::PipelineStageFlags2::ALL_COMMANDS,
            access: vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
            layout: vk::ImageLayout::GENERAL,
        };
        for (id, slot) in (0..).zip(&mut resources.images) {
            match slot {
                ImageSlot::Own(image) if image.is_scratch() => {
                    if !keeps_scratch {
                        self.tracker.discard_image(ImageId(id));
                    }
                }
                ImageSlot::Own(image) if !image.initialised => {
                    image.initialised = true;
                    self.changing.push(change(image.handle, range_of(image), before, all));
                }
                ImageSlot::Own(_) | ImageSlot::Host(_) => {}
            }
        }
        if !self.changing.is_empty() {
            // SAFETY: the caller's.
            unsafe { self.emit(host, stream.current(), &Barrier::default()) };
        }
    }

    /// A barrier, and the changes of images that come with it; nothing if it is empty.
    unsafe fn barrier(&mut self, host: &Host, commands: vk::CommandBuffer, resources: &Resources, barrier: &Barrier) {
        for Change { image, from, to } in self.tracker.changes() {
            let (handle, range) = (resources.image(*image), resources.range(*image));
            if handle == vk::Image::null() {
                continue;
            }
            let from = ImageState {
                stage: from.stage | barrier.src_stage,
                access: from.access | barrier.src_access,
                layout: from.layout,
            };
            let to = ImageState {
                stage: to.stage | barrier.dst_stage,
                access: to.access | barrier.dst_access,
                layout: to.layout,
            };
            self.changing.push(change(handle, range, from, to));
        }
        if !barrier.is_empty() || !self.changing.is_empty() {
            // SAFETY: the caller's.
            unsafe { self.emit(host, commands, barrier) };
        }
    }

    /// All that changes, with a memory barrier, unless that is empty.
    unsafe fn emit(&mut self, host: &Host, commands: vk::CommandBuffer, barrier: &Barrier) {
        let memory = [vk::MemoryBarrier2::default()
            .src_stage_mask(barrier.src_stage)
            .src_access_mask(barrier.src_access)
            .dst_stage_mask(barrier.dst_stage)
            .dst_access_mask(barrier.dst_access)];
        let memory = if barrier.is_empty() { &[][..] } else { &memory };
        let dependency = vk::DependencyInfo::default().memory_barriers(memory).image_memory_barriers(&self.changing);
        // SAFETY: the caller's.
        unsafe { host.device.cmd_pipeline_barrier2(commands, &dependency) };
        self.changing.clear();
    }
}

/// Around each step, to measure it alone.
const ISOLATED: Barrier = Barrier {
    src_stage: vk::PipelineStageFlags2::ALL_COMMANDS,
    src_access: vk::AccessFlags2::MEMORY_WRITE,
    dst_stage: vk::PipelineStageFlags2::ALL_COMMANDS,
    dst_access: vk::AccessFlags2::from_raw(
        vk::AccessFlags2::MEMORY_READ.as_raw() | vk::AccessFlags2::MEMORY_WRITE.as_raw(),
    ),
};

/// The images that the host has handed over.
fn host_images(resources: &Resources) -> impl Iterator<Item = (ImageId, &HostImage)> {
    (0..).zip(&resources.images).filter_map(|(index, slot)| match slot {
        ImageSlot::Host(Some(image)) => Some((ImageId(index), image)),
        ImageSlot::Host(None) | ImageSlot::Own(_) => None,
    })
}

/// An image from one state into another.
fn change(
    image: vk::Image,
    range: vk::ImageSubresourceRange,
    from: ImageState,
    to: ImageState,
) -> vk::ImageMemoryBarrier2<'static> {
    vk::ImageMemoryBarrier2::default()
        .src_stage_mask(from.stage)
        .src_access_mask(from.access)
        .dst_stage_mask(to.stage)
        .dst_access_mask(to.access)
        .old_layout(from.layout)
        .new_layout(to.layout)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image)
        .subresource_range(range)
}

/// Refuses a plan that does not fit the resources: copies of more than there is.
///
/// # Errors
/// Names the pass.
pub fn check(plan: &Plan, passes: &[Pass], resources: &Resources) -> Result<()> {
    for step in &plan.steps {
        let (from, to, bytes) = match step.command {
            Command::CopyBuffer { from, to, bytes } => ((from, 0), (to, 0), bytes),
            Command::CopyRange { from, to, bytes } => (from, to, bytes),
            _ => continue,
        };
        for (verb, (buffer, offset)) in [("read from", from), ("written to", to)] {
            let (needed, available) = (offset + bytes, resources.buffer(buffer).2);
            if needed > available {
                let why = format!("a buffer of {available} bytes; {needed} are {verb} it");
                return Err(Error::HostResource { name: passes[usize::from(step.pass.0)].name, why });
            }
        }
    }
    Ok(())
}

/// The context in which a step is recorded.
struct Walk<'a> {
    host: &'a Host<'a>,
    commands: vk::CommandBuffer,
    resources: &'a Resources,
    plan: &'a Plan,
}

impl Walk<'_> {
    unsafe fn step(&self, step: &Step, pass: &Pass, bound: &Bound) {
        // SAFETY: the caller's.
        unsafe {
            match &pass.kernel {
                Kernel::Compute(shader) => {
                    self.bind(step, pass, bound, vk::PipelineBindPoint::COMPUTE);
                    self.dispatch(step, shader.local_size);
                }
                Kernel::Raster(raster) => {
                    self.bind(step, pass, bound, vk::PipelineBindPoint::GRAPHICS);
                    self.render(step, raster);
                }
                Kernel::Transfer => self.transfer(step),
            }
        }
    }

    unsafe fn bind(&self, step: &Step, pass: &Pass, Bound { pipeline, set }: &Bound, point: vk::PipelineBindPoint) {
        let device = self.host.device;
        let (stages, size) = push_range(pass);
        // SAFETY: the caller's.
        unsafe {
            device.cmd_bind_pipeline(self.commands, point, pipeline.handle);
            device.cmd_bind_descriptor_sets(self.commands, point, pipeline.layout, 0, &[*set], &[]);
            if size > 0 {
                let bytes = &step.constants[..size as usize];
                device.cmd_push_constants(self.commands, pipeline.layout, stages, 0, bytes);
            }
        }
    }

    unsafe fn dispatch(&self, step: &Step, local_size: [u32; 3]) {
        let device = self.host.device;
        // SAFETY: the caller's.
        unsafe {
            match step.command {
                Command::Dispatch { threads } => {
                    let [x, y, z] = [0, 1, 2].map(|axis| threads[axis].div_ceil(local_size[axis]));
                    device.cmd_dispatch(self.commands, x, y, z);
                }
                Command::DispatchIndirect { arguments, offset } => {
                    let (buffer, start, _) = self.resources.buffer(arguments);
                    device.cmd_dispatch_indirect(self.commands, buffer, start + offset);
                }
                _ => debug_assert!(false, "a compute pass dispatches"),
            }
        }
    }

    unsafe fn render(&self, step: &Step, raster: &Raster) {
        let device = self.host.device;
        let load = |clears: bool| if clears { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD };
        let colour = raster.colour.map(|colour| {
            let uint32 = colour.clear.unwrap_or_default();
            vk::RenderingAttachmentInfo::default()
                .image_view(self.resources.attachment_view(colour.image, 0))
                .image_layout(self.layout(colour.image, &Usage::COLOUR))
                .load_op(load(colour.clear.is_some()))
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(vk::ClearValue { color: vk::ClearColorValue { uint32 } })
        });
        let depth = raster.depth.map(|depth| {
            let depth_stencil = vk::ClearDepthStencilValue { depth: depth.clear.unwrap_or_default(), stencil: 0 };
            vk::RenderingAttachmentInfo::default()
                .image_view(self.resources.attachment_view(depth.image, depth.layer))
                .image_layout(self.layout(depth.image, &Usage::DEPTH))
                .load_op(load(depth.clear.is_some()))
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(vk::ClearValue { depth_stencil })
        });
        let attached = raster.colour.map(|colour| colour.image).or(raster.depth.map(|depth| depth.image));
        let area = self.area(attached, raster.extent);
        let mut info =
            vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(colour.as_slice());
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
        }
        // SAFETY: the caller's.
        unsafe {
            device.cmd_set_viewport(self.commands, 0, &[viewport(&area)]);
            device.cmd_set_scissor(self.commands, 0, &[area]);
            device.cmd_begin_rendering(self.commands, &info);
            match step.command {
                Command::DrawIndirect { arguments, offset } => {
                    let (buffer, start, _) = self.resources.buffer(arguments);
                    device.cmd_draw_indirect(self.commands, buffer, start + offset, 1, 16);
                }
                Command::Draw { vertices } => device.cmd_draw(self.commands, vertices, 1, 0, 0),
                _ => debug_assert!(false, "a render pass draws"),
            }
            device.cmd_end_rendering(self.commands);
        }
    }

    /// Where a picture of this size lies in what is attached.
    fn area(&self, attached: Option<ImageId>, [width, height]: [u32; 2]) -> vk::Rect2D {
        let [x, y] = attached.map_or([0; 2], |id| self.resources.offset(id)).map(|side| side as i32);
        vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } }
    }

    /// Where a picture begins in an image that is copied.
    fn corner(&self, id: ImageId) -> vk::Offset3D {
        let [x, y] = self.resources.offset(id).map(|side| side as i32);
        vk::Offset3D { x, y, z: 0 }
    }

    /// The layout of an image while it is used so.
    fn layout(&self, id: ImageId, usage: &Usage) -> vk::ImageLayout {
        let is_host = matches!(&self.resources.images[usize::from(id.0)], ImageSlot::Host(_));
        layout(is_host, usage)
    }

    /// The layer of an image that is copied.
    fn layer(&self, id: ImageId, aspect_mask: vk::ImageAspectFlags) -> vk::ImageSubresourceLayers {
        let vk::ImageSubresourceRange { base_mip_level: mip_level, base_array_layer, .. } = self.resources.range(id);
        vk::ImageSubresourceLayers { aspect_mask, mip_level, base_array_layer, layer_count: 1 }
    }

    unsafe fn copy(&self, from: (BufferId, u64), to: (BufferId, u64), size: u64) {
        let (source, src_offset, _) = self.resources.buffer(from.0);
        let (target, dst_offset, _) = self.resources.buffer(to.0);
        let (src_offset, dst_offset) = (src_offset + from.1, dst_offset + to.1);
        let regions = [vk::BufferCopy { src_offset, dst_offset, size }];
        // SAFETY: the caller's.
        unsafe { self.host.device.cmd_copy_buffer(self.commands, source, target, &regions) };
    }

    unsafe fn transfer(&self, step: &Step) {
        let device = self.host.device;
        // SAFETY: the caller's.
        unsafe {
            match step.command {
                Command::Fill { buffer, word } => {
                    let (buffer, offset, size) = self.resources.buffer(buffer);
                    device.cmd_fill_buffer(self.commands, buffer, offset, size & !3, word);
                }
                Command::Update { buffer, from, bytes } => {
                    let (buffer, offset, _) = self.resources.buffer(buffer);
                    device.cmd_update_buffer(self.commands, buffer, offset, &self.plan.data[from..from + bytes]);
                }
                Command::Clear { image, value, extent } => {
                    let colour = [vk::RenderingAttachmentInfo::default()
                        .image_view(self.resources.attachment_view(image, 0))
                        .image_layout(self.layout(image, &Usage::COLOUR))
                        .load_op(vk::AttachmentLoadOp::CLEAR)
                        .store_op(vk::AttachmentStoreOp::STORE)
                        .clear_value(vk::ClearValue { color: vk::ClearColorValue { uint32: value } })];
                    let area = self.area(Some(image), extent);
                    let info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colour);
                    device.cmd_begin_rendering(self.commands, &info);
                    device.cmd_end_rendering(self.commands);
                }
                Command::CopyBuffer { from, to, bytes } => self.copy((from, 0), (to, 0), bytes),
                Command::CopyRange { from, to, bytes } => self.copy(from, to, bytes),
                Command::CopyImage { from, to, extent: [width, height] } => {
                    let regions = [vk::ImageCopy::default()
                        .src_subresource(self.layer(from, vk::ImageAspectFlags::COLOR))
                        .src_offset(self.corner(from))
                        .dst_subresource(self.layer(to, vk::ImageAspectFlags::COLOR))
                        .dst_offset(self.corner(to))
                        .extent(vk::Extent3D { width, height, depth: 1 })];
                    let source = (self.resources.image(from), self.layout(from, &Usage::COPY_SOURCE));
                    let target = (self.resources.image(to), self.layout(to, &Usage::COPY_TARGET));
                    device.cmd_copy_image(self.commands, source.0, source.1, target.0, target.1, &regions);
                }
                Command::CopyDepth { from, to, extent: [width, height] } => {
                    let (to, buffer_offset, _) = self.resources.buffer(to);
                    let regions = [vk::BufferImageCopy::default()
                        .buffer_offset(buffer_offset)
                        .image_subresource(self.layer(from, vk::ImageAspectFlags::DEPTH))
                        .image_offset(self.corner(from))
                        .image_extent(vk::Extent3D { width, height, depth: 1 })];
                    let (image, layout) = (self.resources.image(from), self.layout(from, &Usage::COPY_SOURCE));
                    device.cmd_copy_image_to_buffer(self.commands, image, layout, to, &regions);
                }
                _ => debug_assert!(false, "a transfer pass copies, clears, fills or updates"),
            }
        }
    }
}
