//! Single passes of the effect on inputs that the test chooses: the plan of a frame, less the steps whose results are
//! written instead. Made of the engine's public pieces, as the effect itself is.

use ash::vk;
use celfx::data::Volume;
use celfx::effect::Inventory;
use celfx::error::Result;
use celfx::gpu::buffer::{Buffer, BufferDesc};
use celfx::gpu::image::{Image, ImageDesc};
use celfx::gpu::kernel::Pipelines;
use celfx::gpu::profiler::Timing;
use celfx::gpu::recorder::{Recorder, Recording};
use celfx::gpu::resources::Resources;
use celfx::host::{Host, HostBuffer, HostImage, ImageState};
use celfx::offline::TARGET_FORMAT;
use celfx::plan::{BufferId, Plan};
use celfx::smoke::layout::{self, Layout};
use celfx::smoke::params::SmokeParams;
use celfx::smoke::passes::Passes;
use celfx::smoke::steps::{Moment, Steps};
use celfx::smoke::tables::Tables;
use celfx::smoke::{Background, Desc, Frame, Sequence, Shape, VolumeInput};
use celfx::view::{Camera, Light};
use gpu_allocator::MemoryLocation;

use super::{TestDevice, device};

/// Lavapipe's largest range of a storage buffer, the smallest of the devices that tests run on.
pub const RANGE: u64 = 128 << 20;

/// The effect's passes, and buffers that tests write and read.
pub struct Bench {
    device: TestDevice,
    /// Settings may be changed between frames where the passes learn of them through parameters or tables.
    pub desc: Desc,
    pub layout: Layout,
    passes: Passes,
    plan: Plan,
    resources: Resources,
    pipelines: Option<Pipelines>,
    recorder: Recorder,
    target: Option<Image>,
}

/// A frame of a bench.
pub struct Given<'a> {
    pub camera: Camera,
    pub light: Light,
    pub volume: &'a Volume,
    /// Frames since the restart; 0 restarts.
    pub frames: u32,
    /// Whether a picture is made.
    pub rendered: bool,
    /// Steps that are left out: their results have been written.
    pub omit: &'a [&'a str],
}

impl Bench {
    /// None where there is no device and tests may do without.
    pub fn new(desc: Desc) -> Option<Bench> {
        let mut device = device()?;
        let layout = Layout::new(&desc, RANGE).expect("a layout");
        let passes = Passes::new(&desc, &layout, &Tables::new(&desc.settings, &layout));
        let mut resources = Resources::default();
        let (host, allocator) = device.parts();
        // SAFETY: the handles are the device's own; everything is destroyed before it.
        let (pipelines, target) = unsafe {
            for buffer in layout.buffers() {
                resources.add_buffer(&host, allocator, &buffer).expect("a buffer");
            }
            resources.add_host_buffer();
            resources.add_host_buffer();
            for mut image in layout.images(&desc) {
                if image.format == vk::Format::R32_UINT {
                    image.usage |= vk::ImageUsageFlags::TRANSFER_DST;
                }
                resources.add_image(&host, allocator, &image).expect("an image");
            }
            resources.add_host_image();
            resources.add_host_image();
            let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST;
            let target = ImageDesc {
                name: "bench target",
                extent: desc.size,
                layers: 1,
                array_view: false,
                format: TARGET_FORMAT,
                usage,
            };
            let target = Image::new(&host, allocator, &target).expect("a target");
            (Pipelines::new(&host, &passes.list, &resources).expect("pipelines"), target)
        };
        let recorder = Recorder::new(&resources);
        let plan = Plan::default();
        let (pipelines, target) = (Some(pipelines), Some(target));
        Some(Bench { device, desc, layout, passes, plan, resources, pipelines, recorder, target })
    }

    fn staging(&mut self, bytes: u64, location: MemoryLocation) -> Buffer {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let desc = BufferDesc { name: "bench staging", size: bytes.max(16), usage, location };
        let (host, allocator) = self.device.parts();
        // SAFETY: the handles are the device's own.
        unsafe { Buffer::new(&host, allocator, &desc) }.expect("a staging buffer")
    }

    fn upload(&mut self, bytes: &[u8]) -> Buffer {
        let mut buffer = self.staging(bytes.len() as u64, MemoryLocation::CpuToGpu);
        buffer.mapped_mut().expect("mapped memory")[..bytes.len()].copy_from_slice(bytes);
        buffer
    }

    fn free(&mut self, mut buffer: Buffer) {
        let (host, allocator) = self.device.parts();
        // SAFETY: every submission has been waited for.
        unsafe { buffer.destroy(&host, allocator) };
    }

    /// Writes the start of a buffer.
    pub fn write<T: bytemuck::NoUninit>(&mut self, id: BufferId, values: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let from = self.upload(bytes);
        let (to, _, size) = self.resources.buffer(id);
        assert!(bytes.len() as u64 <= size, "{id:?} holds {size} bytes");
        let regions = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: bytes.len() as u64 }];
        let done = self.device.one_time("bench write", |host, commands| {
            // SAFETY: both buffers are alive; nothing else is on its way.
            unsafe {
                full_barrier(host, commands);
                host.device.cmd_copy_buffer(commands, from.handle, to, &regions);
                full_barrier(host, commands);
            }
            Ok(())
        });
        done.expect("the copy runs");
        self.free(from);
    }

    /// Writes what each pixel has seen: `(slot + 1) << 8 | group`, 0 for nothing. After the first frame.
    pub fn write_seen(&mut self, codes: &[u32]) {
        let [width, height] = self.desc.size;
        assert_eq!(codes.len(), (width * height) as usize);
        let from = self.upload(bytemuck::cast_slice(codes));
        let image = self.resources.image(layout::SEEN);
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let extent = vk::Extent3D { width, height, depth: 1 };
        let regions = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)];
        let done = self.device.one_time("bench write seen", |host, commands| {
            // SAFETY: buffer and image are alive; the image has been in layout GENERAL since the first frame.
            unsafe {
                let (general, copied) = (vk::ImageLayout::GENERAL, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
                change_layout(host, commands, image, general, copied);
                host.device.cmd_copy_buffer_to_image(commands, from.handle, image, copied, &regions);
                change_layout(host, commands, image, copied, general);
            }
            Ok(())
        });
        done.expect("the copy runs");
        self.free(from);
    }

    /// Reads the first `count` values of a buffer.
    pub fn read<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId, count: usize) -> Vec<T> {
        let (from, _, available) = self.resources.buffer(id);
        let size = (count * size_of::<T>()) as u64;
        assert!(size <= available, "{id:?} holds {available} bytes");
        if size == 0 {
            return Vec::new();
        }
        let to = self.staging(size, MemoryLocation::GpuToCpu);
        let regions = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size }];
        let done = self.device.one_time("bench read", |host, commands| {
            // SAFETY: both buffers are alive; nothing else is on its way.
            unsafe {
                full_barrier(host, commands);
                host.device.cmd_copy_buffer(commands, from, to.handle, &regions);
                full_barrier(host, commands);
            }
            Ok(())
        });
        done.expect("the copy runs");
        let bytes = to.mapped().expect("mapped memory")[..size as usize].to_vec();
        self.free(to);
        bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
    }

    /// Plans a frame, leaves steps out, and runs the rest.
    pub fn run(&mut self, given: &Given) {
        let Volume { dimensions, voxel_size, origin, .. } = *given.volume;
        let upload = self.upload(bytemuck::cast_slice(&given.volume.density));
        let density = HostBuffer {
            buffer: upload.handle,
            offset: 0,
            size: upload.size,
            stage: vk::PipelineStageFlags2::NONE,
            access: vk::AccessFlags2::NONE,
        };
        let target = given.rendered.then(|| self.target());
        let restart = given.frames == 0;
        let frame = Frame {
            sequence: if restart { Sequence::Restart } else { Sequence::Advance },
            dt: 1.0 / 24.0,
            camera: given.camera,
            light: given.light,
            volume: Some(VolumeInput { dimensions, voxel_size, origin, density, velocity: None }),
            target,
            background: Background::Clear([0.0; 4]),
            depth: None,
            edges: None,
        };
        let shape = Shape { dimensions, voxel_size, origin };
        let moment = Moment { shape, restart, new_volume: true, first: true, still: None, same_shadow: None };
        let params = SmokeParams::new(&self.desc, &self.layout, &frame, &shape, given.frames);
        let tables = Tables::new(&self.desc.settings, &self.layout);
        let Bench { plan, passes, desc, layout, .. } = self;
        plan.clear();
        Steps { plan, passes, desc, layout, moment: &moment }.fill(&frame, &params, &tables);
        let list = &self.passes.list;
        self.plan.steps.retain(|step| !given.omit.contains(&list[usize::from(step.pass.0)].name));
        self.resources.set_host_buffer(layout::HOST_DENSITY, Some(density));
        self.resources.set_host_image(layout::TARGET, target);
        self.submit().expect("the frame runs");
        self.free(upload);
    }

    fn target(&self) -> HostImage {
        let image = self.target.as_ref().expect("a target");
        let state_out = ImageState {
            stage: vk::PipelineStageFlags2::ALL_COMMANDS,
            access: vk::AccessFlags2::MEMORY_WRITE,
            layout: vk::ImageLayout::GENERAL,
        };
        let (image, view) = (image.handle, image.view);
        let state_in = ImageState::default();
        HostImage { image, view, format: TARGET_FORMAT, extent: self.desc.size, state_in, state_out }
    }

    fn submit(&mut self) -> Result<()> {
        let Bench { device, passes, plan, resources, pipelines, recorder, .. } = self;
        let pipelines = pipelines.as_ref().expect("pipelines");
        device.one_time("bench frame", |host, commands| {
            let passes = &passes.list;
            let mut commands = commands;
            let mut recording = Recording { host, stream: &mut commands, passes, pipelines, resources };
            // SAFETY: everything was made for these passes, and what the plan names has been handed over.
            unsafe { recorder.record(plan, &mut recording, &mut Timing::None) }
        })
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let (pipelines, target) = (self.pipelines.take(), self.target.take());
        let (host, allocator) = self.device.parts();
        // SAFETY: every submission has been waited for.
        unsafe {
            if let Some(mut pipelines) = pipelines {
                pipelines.destroy(&host);
            }
            if let Some(mut target) = target {
                target.destroy(&host, allocator);
            }
            self.resources.destroy(&host, allocator);
        }
    }
}

unsafe fn full_barrier(host: &Host, commands: vk::CommandBuffer) {
    let barriers = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barriers);
    // SAFETY: the caller's.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &dependency) };
}

unsafe fn change_layout(
    host: &Host,
    commands: vk::CommandBuffer,
    image: vk::Image,
    from: vk::ImageLayout,
    to: vk::ImageLayout,
) {
    let range = vk::ImageSubresourceRange {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        base_mip_level: 0,
        level_count: 1,
        base_array_layer: 0,
        layer_count: 1,
    };
    let barriers = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
        .old_layout(from)
        .new_layout(to)
        .image(image)
        .subresource_range(range)];
    let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
    // SAFETY: the caller's.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &dependency) };
}
