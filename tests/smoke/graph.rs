//! A host that records plans by itself, with barriers of its own: one that orders everything, before each step.

use ash::vk;
use celfx::effect::{Effect, Kind, StepParts};
use celfx::host::{Host, HostImage, ImageState};
use celfx::low_level::gpu::transfer::{CLEARED, COPIED_FROM};
use celfx::low_level::plan::{Command, ImageId, Kernel, Plan, Raster};
use celfx::low_level::smoke::layout::{SEEN, SEEN_DEPTH, SHADOW_MAP, TARGET};
use celfx::offline::TARGET_FORMAT;
use celfx::profile::Timing;
use celfx::program::vignette::{self, VignetteKind};
use celfx::smoke::settings::Shadow;
use celfx::smoke::{Background, Desc, Frame, Settings, Smoke};

use crate::common::device;
use crate::common::host::{self, ALL, ALL_WRITTEN, DISCARDED};
use crate::host::{SIZE, Slot, effect};

/// Every image is in this layout while steps run.
const GENERAL: ImageState = ImageState { stage: ALL.0, access: ALL.1, layout: vk::ImageLayout::GENERAL };

/// Walks a plan into a command buffer.
struct Walker<'a, K: Kind> {
    host: &'a Host<'a>,
    commands: vk::CommandBuffer,
    effect: &'a Effect<K>,
}

impl<K: Kind> Walker<'_, K> {
    /// The steps; the target is in layout GENERAL, and the effect's `own` images are brought there.
    unsafe fn walk(&self, plan: &Plan, own: &[ImageId]) {
        // SAFETY: the caller's, for all of it.
        unsafe {
            for image in own.iter().filter(|id| self.effect.is_new(**id)) {
                self.change(*image, DISCARDED, GENERAL);
            }
            for index in 0..plan.steps.len() {
                host::barrier(self.host, self.commands, ALL_WRITTEN, ALL);
                self.step(plan, self.effect.step(index).expect("a step"));
            }
        }
        assert!(self.effect.step(plan.steps.len()).is_none());
    }

    unsafe fn change(&self, id: ImageId, from: ImageState, to: ImageState) {
        let (image, range) = self.effect.image(id);
        // SAFETY: the caller's.
        unsafe { host::change(self.host, self.commands, (image, range.aspect_mask), from, to) };
    }

    unsafe fn step(&self, plan: &Plan, parts: StepParts) {
        let StepParts { pass, pipeline, layout, set, push_stages, push_constants, .. } = parts;
        let (device, commands) = (self.host.device, self.commands);
        let point = match &pass.kernel {
            Kernel::Compute(_) => vk::PipelineBindPoint::COMPUTE,
            Kernel::Raster(_) => vk::PipelineBindPoint::GRAPHICS,
            // SAFETY: the caller's.
            Kernel::Transfer => return unsafe { self.transfer(plan, parts.step.command) },
        };
        // SAFETY: the caller's.
        unsafe {
            device.cmd_bind_pipeline(commands, point, pipeline);
            device.cmd_bind_descriptor_sets(commands, point, layout, 0, &[set], &[]);
            if !push_constants.is_empty() {
                device.cmd_push_constants(commands, layout, push_stages, 0, push_constants);
            }
            match (&pass.kernel, parts.step.command) {
                (Kernel::Compute(shader), Command::Dispatch { threads }) => {
                    let groups = [0, 1, 2].map(|axis| threads[axis].div_ceil(shader.local_size[axis]));
                    device.cmd_dispatch(commands, groups[0], groups[1], groups[2]);
                }
                (Kernel::Compute(_), Command::DispatchIndirect { arguments, offset }) => {
                    let (buffer, start, _) = self.effect.buffer(arguments);
                    device.cmd_dispatch_indirect(commands, buffer, start + offset);
                }
                (Kernel::Raster(raster), command) => self.draw(raster, command),
                other => panic!("{}: {other:?}", pass.name),
            }
        }
    }

    unsafe fn draw(&self, raster: &Raster, command: Command) {
        let (device, commands) = (self.host.device, self.commands);
        let load = |clears| if clears { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD };
        let attachment = |image, layer, clears, clear_value| {
            vk::RenderingAttachmentInfo::default()
                .image_view(self.effect.attachment(image, layer))
                .image_layout(vk::ImageLayout::GENERAL)
                .load_op(load(clears))
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(clear_value)
        };
        let colour = raster.colour.map(|colour| {
            let uint32 = colour.clear.unwrap_or_default();
            let value = vk::ClearValue { color: vk::ClearColorValue { uint32 } };
            attachment(colour.image, 0, colour.clear.is_some(), value)
        });
        let depth = raster.depth.map(|depth| {
            let depth_stencil = vk::ClearDepthStencilValue { depth: depth.clear.unwrap_or_default(), stencil: 0 };
            attachment(depth.image, depth.layer, depth.clear.is_some(), vk::ClearValue { depth_stencil })
        });
        let [width, height] = raster.extent;
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let [w, h] = [width as f32, height as f32];
        let viewport = vk::Viewport { x: 0.0, y: 0.0, width: w, height: h, min_depth: 0.0, max_depth: 1.0 };
        let mut info =
            vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(colour.as_slice());
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
        }
        // SAFETY: the caller's.
        unsafe {
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            device.cmd_begin_rendering(commands, &info);
            match command {
                Command::Draw { vertices } => device.cmd_draw(commands, vertices, 1, 0, 0),
                Command::DrawIndirect { arguments, offset } => {
                    let (buffer, start, _) = self.effect.buffer(arguments);
                    device.cmd_draw_indirect(commands, buffer, start + offset, 1, 16);
                }
                other => panic!("{other:?} in a render pass"),
            }
            device.cmd_end_rendering(commands);
        }
    }

    unsafe fn transfer(&self, plan: &Plan, command: Command) {
        let (device, commands) = (self.host.device, self.commands);
        // SAFETY: the caller's.
        unsafe {
            match command {
                Command::Fill { buffer, word } => {
                    let (buffer, offset, size) = self.effect.buffer(buffer);
                    device.cmd_fill_buffer(commands, buffer, offset, size & !3, word);
                }
                Command::Update { buffer, from, bytes } => {
                    let (buffer, offset, _) = self.effect.buffer(buffer);
                    device.cmd_update_buffer(commands, buffer, offset, &plan.data[from..from + bytes]);
                }
                Command::Clear { image, value, .. } => {
                    let (image, range) = self.effect.image(image);
                    let colour = vk::ClearColorValue { uint32: value };
                    device.cmd_clear_color_image(commands, image, vk::ImageLayout::GENERAL, &colour, &[range]);
                }
                Command::CopyBuffer { from, to, bytes: size } => {
                    let ((from, src_offset, _), (to, dst_offset, _)) =
                        (self.effect.buffer(from), self.effect.buffer(to));
                    device.cmd_copy_buffer(commands, from, to, &[vk::BufferCopy { src_offset, dst_offset, size }]);
                }
                other => panic!("the tests' effects do not need {other:?}"),
            }
        }
    }
}

#[test]
fn a_frame_graph_records_the_plan_by_itself() {
    let Some(mut device) = device() else { return };
    for shadow in [Shadow::Exact, Shadow::Map] {
        let settings = Settings { shadow, shadow_map: 64, ..effect().settings };
        let desc = Desc { settings, ..effect() };
        let (host, kernels, allocator) = device.making();
        // SAFETY: the handles are the device's own.
        let [mut walked, mut whole] =
            [(); 2].map(|()| unsafe { Smoke::new(&host, kernels, allocator, desc.clone()) }.expect("an effect"));
        assert_eq!(walked.recorded().expect_err("no frame").to_string(), "frame: none is prepared");
        for i in 0..4 {
            let (mut ours, mut theirs) = (Slot::new(&mut device, SIZE), Slot::new(&mut device, SIZE));
            walked.prepare(&ours.frame(i)).expect("a frame");
            let frame = theirs.frame(i);
            host::run(&mut device, |host, commands| {
                // SAFETY: everything is the test's own and waited for.
                unsafe {
                    let walker = Walker { host, commands, effect: &walked };
                    walker.change(TARGET, DISCARDED, GENERAL);
                    walker.walk(walked.plan(), &[SEEN, SEEN_DEPTH, SHADOW_MAP]);
                    walker.change(TARGET, GENERAL, COPIED_FROM);
                    ours.show(host, commands);
                    whole.record(host, commands, &frame, &mut Timing::None).expect("a frame");
                    theirs.show(host, commands);
                }
            });
            walked.recorded().expect("a prepared frame");
            assert!(ours.pixels() == theirs.pixels(), "{shadow:?}: frame {i}");
            [ours, theirs].into_iter().for_each(|slot| slot.destroy(&mut device));
        }
        let (host, allocator) = device.parts();
        // SAFETY: every frame has been waited for.
        [walked, whole].into_iter().for_each(|smoke| unsafe { smoke.retire().destroy(&host, allocator) });
    }
}

/// A host that draws before and after, and binds again what recording disturbs: its pipeline, its set, viewport and scissor. Its
/// draws are a vignette, whose picture depends on all of them.
#[test]
fn a_host_draws_before_and_after() {
    let Some(mut device) = device() else { return };
    let (host, kernels, allocator) = device.making();
    let dark = vignette::Desc { size: SIZE, target_format: TARGET_FORMAT, strength: 0.7, radius: 0.2 };
    // SAFETY: the handles are the device's own.
    let (mut smoke, mut vignette) = unsafe {
        let smoke = Smoke::new(&host, kernels, allocator, effect()).expect("an effect");
        (smoke, Effect::<VignetteKind>::new(&host, kernels, allocator, dark).expect("an effect"))
    };
    let mut pictures = Vec::new();
    for is_one_buffer in [true, false] {
        let mut slot = Slot::new(&mut device, SIZE);
        let frame = slot.frame(0);
        let target = frame.target.expect("a target");
        let between = HostImage { state_in: GENERAL, state_out: GENERAL, ..target };
        let frame = Frame { target: Some(between), background: Background::Keep, ..frame };
        vignette.prepare(&between).expect("a frame");
        let draw = |host: &Host, commands| {
            // SAFETY: everything is the test's own and waited for.
            unsafe { Walker { host, commands, effect: &vignette }.walk(vignette.plan(), &[]) };
        };
        let before = |host: &Host, commands| {
            // SAFETY: as above.
            unsafe {
                let image = (target.image, vk::ImageAspectFlags::COLOR);
                host::change(host, commands, image, DISCARDED, CLEARED);
                let sky = vk::ClearColorValue { float32: [0.2, 0.5, 0.9, 1.0] };
                let range = [host::whole(vk::ImageAspectFlags::COLOR)];
                host.device.cmd_clear_color_image(commands, target.image, CLEARED.layout, &sky, &range);
                host::change(host, commands, image, CLEARED, GENERAL);
            }
            draw(host, commands);
        };
        let mut record = |host: &Host, commands| {
            // SAFETY: as above.
            unsafe { smoke.record(host, commands, &frame, &mut Timing::None) }.expect("a frame");
        };
        let after = |host: &Host, commands| {
            draw(host, commands);
            // SAFETY: as above.
            unsafe {
                host::change(host, commands, (target.image, vk::ImageAspectFlags::COLOR), GENERAL, COPIED_FROM);
                slot.show(host, commands);
            }
        };
        match is_one_buffer {
            true => host::run(&mut device, |host, commands| {
                before(host, commands);
                record(host, commands);
                after(host, commands);
            }),
            false => {
                host::run(&mut device, before);
                host::run(&mut device, &mut record);
                host::run(&mut device, after);
            }
        }
        pictures.push(slot.pixels());
        slot.destroy(&mut device);
    }
    assert!(pictures[0] == pictures[1]);
    let corners = [pictures[0][0], pictures[0][(SIZE[0] * SIZE[1] / 2 + SIZE[0] / 2) as usize]];
    assert!(corners[0] != corners[1], "no vignette");
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe {
        smoke.retire().destroy(&host, allocator);
        vignette.retire().destroy(&host, allocator);
    }
}
