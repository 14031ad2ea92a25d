//! A host of celfx's own: renders the smoke effect's frames into memory, for the program, the benchmark and tests.
//!
//! One frame at a time: upload the volume, record, submit, wait, read back.

use ash::vk;
use gpu_allocator::MemoryLocation;

use crate::error::{Error, Result};
use crate::gpu::buffer::{Buffer, BufferDesc};
use crate::gpu::headless::Headless;
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::profiler::{Profiler, Timing};
use crate::host::{Host, HostBuffer, HostImage, ImageState};
use crate::io::volume::Volume;
use crate::plan::BufferId;
use crate::profile::FrameTimes;
use crate::smoke::{Background, Desc, Frame, Sequence, Smoke, VolumeInput};
use crate::view::{Camera, Light};

/// Format of the target that frames are rendered to.
pub const TARGET_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// One frame, as a shot says it.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// How it follows the frame before.
    pub sequence: Sequence,
    /// Seconds until the next frame.
    pub dt: f32,
    /// What sees it.
    pub camera: Camera,
    /// What lights it.
    pub light: Light,
    /// Its volume; none if it is the last one.
    pub volume: Option<&'a Volume>,
    /// Whether it is rendered, or only moves the particles on.
    pub rendered: bool,
    /// Number of the frame in profiles.
    pub number: u32,
}

/// A device, the effect on it, and what carries volumes to it and pictures back.
pub struct Offline {
    device: Headless,
    parts: Parts,
    size: [u32; 2],
    background: [f32; 4],
    has_backdrop: bool,
}

/// What must be destroyed by hand.
#[derive(Default)]
struct Parts {
    smoke: Option<Smoke>,
    volume: Option<Buffer>,
    velocity: Option<Buffer>,
    target: Option<Image>,
    backdrop: Option<Image>,
    picture: Option<Buffer>,
    profiler: Option<Profiler>,
}

impl Offline {
    /// Makes the effect on `device`. `desc.target_format` is [`TARGET_FORMAT`].
    ///
    /// # Errors
    /// As [`Smoke::new`]; the device is lost with it.
    pub fn new(device: Headless, desc: Desc) -> Result<Offline> {
        let size = desc.size;
        let mut offline = Offline { device, parts: Parts::default(), size, background: [0.0; 4], has_backdrop: false };
        offline.create(desc)?;
        Ok(offline)
    }

    fn create(&mut self, desc: Desc) -> Result<()> {
        let voxels: u64 = desc.dimensions.iter().map(|n| u64::from(*n)).product();
        let pixels = u64::from(desc.size[0]) * u64::from(desc.size[1]);
        let has_velocity = desc.velocity;
        let upload = |name, size| BufferDesc {
            name,
            size,
            usage: vk::BufferUsageFlags::TRANSFER_SRC,
            location: MemoryLocation::CpuToGpu,
        };
        let picture = BufferDesc {
            name: "picture read back",
            size: pixels * 16,
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            location: MemoryLocation::GpuToCpu,
        };
        let queue_family = self.device.queue_family();
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own and outlives what is made here.
        unsafe {
            let smoke = self.parts.smoke.insert(Smoke::new(&host, allocator, desc)?);
            let (steps, _) = smoke.plan_capacity();
            self.parts.profiler = Some(Profiler::new(&host, queue_family, 1, steps as u32)?);
            self.parts.target = Some(Image::new(&host, allocator, &target_desc("target", self.size))?);
            self.parts.volume = Some(Buffer::new(&host, allocator, &upload("volume upload", voxels * 4))?);
            if has_velocity {
                self.parts.velocity = Some(Buffer::new(&host, allocator, &upload("velocity upload", voxels * 12))?);
            }
            self.parts.picture = Some(Buffer::new(&host, allocator, &picture)?);
        }
        Ok(())
    }

    /// The colour under the smoke: linear RGBA, premultiplied. Black and transparent at first.
    pub fn set_background(&mut self, colour: [f32; 4]) {
        self.background = colour;
        self.has_backdrop = false;
    }

    /// A picture of the target's size under the smoke: linear RGBA, premultiplied, rows from the top.
    ///
    /// # Errors
    /// Another size; no memory; a failed Vulkan call.
    pub fn set_backdrop(&mut self, pixels: &[[f32; 4]]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(pixels);
        let desc = BufferDesc {
            name: "backdrop upload",
            size: bytes.len().max(16) as u64,
            usage: vk::BufferUsageFlags::TRANSFER_SRC,
            location: MemoryLocation::CpuToGpu,
        };
        if pixels.len() as u64 != u64::from(self.size[0]) * u64::from(self.size[1]) {
            let why = format!("{} pixels, {:?} expected", pixels.len(), self.size);
            return Err(Error::HostResource { name: "background", why });
        }
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own; the image lives until `drop`.
        let mut upload = unsafe {
            if self.parts.backdrop.is_none() {
                self.parts.backdrop = Some(Image::new(&host, allocator, &target_desc("backdrop", self.size))?);
            }
            Buffer::new(&host, allocator, &desc)?
        };
        if let Some(memory) = upload.mapped_mut() {
            memory[..bytes.len()].copy_from_slice(bytes);
        }
        let (size, image) = (self.size, self.parts.backdrop.as_ref().map_or(vk::Image::null(), |i| i.handle));
        let done = self.device.one_time("backdrop", |host, commands| {
            // SAFETY: buffer and image are alive until the wait is over.
            unsafe { upload_image(host, commands, upload.handle, image, size) };
            Ok(())
        });
        let (host, allocator) = self.device.parts();
        // SAFETY: the copy is over.
        unsafe { upload.destroy(&host, allocator) };
        self.has_backdrop = done.is_ok();
        done
    }

    /// Renders a frame and waits for it.
    ///
    /// # Errors
    /// As [`Smoke::record`]; a lost device; a device that does not answer.
    pub fn frame(&mut self, scene: &Scene) -> Result<()> {
        let Parts { smoke, volume, velocity, target, backdrop, picture, profiler } = &mut self.parts;
        let (Some(smoke), Some(density), Some(target), Some(picture), Some(profiler)) =
            (smoke, volume, target, picture, profiler)
        else {
            return Ok(());
        };
        let input = scene.volume.map(|volume| upload_volume(volume, density, velocity.as_mut()));
        let backdrop = backdrop.as_ref().filter(|_| self.has_backdrop);
        let frame = Frame {
            sequence: scene.sequence,
            dt: scene.dt,
            camera: scene.camera,
            light: scene.light,
            volume: input,
            target: scene.rendered.then(|| target_image(target, self.size)),
            background: match backdrop {
                Some(image) => Background::Copy(backdrop_image(image, self.size)),
                None => Background::Clear(self.background),
            },
        };
        let (number, size, rendered) = (scene.number, self.size, scene.rendered);
        self.device.one_time(&format!("frame {number}"), |host, commands| {
            // SAFETY: everything is this host's own, in the declared states, and the frame is waited for.
            unsafe {
                profiler.begin_frame(host, commands, 0, number)?;
                smoke.record(host, commands, &frame, &mut Timing::Profiler(profiler))?;
                if rendered {
                    read_image(host, commands, target.handle, picture.handle, size);
                }
            }
            Ok(())
        })
    }

    /// The picture of the frame rendered last: linear RGBA, premultiplied, rows from the top.
    pub fn picture(&self) -> &[[f32; 4]] {
        let bytes = self.parts.picture.as_ref().and_then(Buffer::mapped).unwrap_or_default();
        bytemuck::cast_slice(bytes)
    }

    /// The first `bytes` of a buffer of the effect after the last frame; all of it if it is smaller.
    ///
    /// # Errors
    /// No memory; a failed Vulkan call.
    pub fn read(&mut self, id: BufferId, bytes: u64) -> Result<Vec<u8>> {
        let Some(smoke) = &self.parts.smoke else { return Ok(Vec::new()) };
        let (source, offset, size) = smoke.buffer(id);
        let size = size.min(bytes);
        let desc = BufferDesc {
            name: "layer read back",
            size: size.max(16),
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            location: MemoryLocation::GpuToCpu,
        };
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own; the buffer lives until the copy is over.
        let mut staging = unsafe { Buffer::new(&host, allocator, &desc)? };
        let done = self.device.one_time("read back", |host, commands| {
            let regions = [vk::BufferCopy { src_offset: offset, dst_offset: 0, size }];
            if size > 0 {
                // SAFETY: both buffers are alive, and the frame that wrote the source has been waited for.
                unsafe {
                    visible_to_copy(host, commands);
                    host.device.cmd_copy_buffer(commands, source, staging.handle, &regions);
                }
            }
            Ok(())
        });
        let result = staging.mapped().map_or(Vec::new(), |memory| memory[..size as usize].to_vec());
        let (host, allocator) = self.device.parts();
        // SAFETY: the copy is over.
        unsafe { staging.destroy(&host, allocator) };
        done.map(|()| result)
    }

    /// [`Offline::read`] as values of a plain type.
    ///
    /// # Errors
    /// As [`Offline::read`].
    pub fn read_as<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId, count: usize) -> Result<Vec<T>> {
        let bytes = self.read(id, (count * size_of::<T>()) as u64)?;
        Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }

    /// Times of the frame rendered last; none where the device has no timestamps.
    pub fn times(&mut self) -> Option<FrameTimes> {
        // SAFETY: every frame has been waited for.
        unsafe { self.parts.profiler.as_mut()?.collect(&self.device.host(), 0) }
    }

    /// The effect; none only if it could not be made.
    pub fn smoke(&mut self) -> Option<&mut Smoke> {
        self.parts.smoke.as_mut()
    }

    /// The device.
    pub fn device(&self) -> &Headless {
        &self.device
    }
}

impl Drop for Offline {
    fn drop(&mut self) {
        let Parts { smoke, volume, velocity, target, backdrop, picture, profiler } = std::mem::take(&mut self.parts);
        let (host, allocator) = self.device.parts();
        // SAFETY: every submission has been waited for.
        unsafe {
            if let Some(mut smoke) = smoke {
                smoke.destroy(&host, allocator);
            }
            for mut buffer in [volume, velocity, picture].into_iter().flatten() {
                buffer.destroy(&host, allocator);
            }
            for mut image in [target, backdrop].into_iter().flatten() {
                image.destroy(&host, allocator);
            }
            if let Some(mut profiler) = profiler {
                profiler.destroy(&host);
            }
        }
    }
}

fn target_desc(name: &'static str, extent: [u32; 2]) -> ImageDesc {
    let usage =
        vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
    ImageDesc { name, extent, layers: 1, array_view: false, format: TARGET_FORMAT, usage }
}

fn upload_volume(volume: &Volume, density: &mut Buffer, velocity: Option<&mut Buffer>) -> VolumeInput {
    // The host's writes are visible to what is submitted after them.
    let filled = |buffer: &mut Buffer, bytes: &[u8]| {
        if let Some(memory) = buffer.mapped_mut() {
            let length = bytes.len().min(memory.len());
            memory[..length].copy_from_slice(&bytes[..length]);
        }
        HostBuffer {
            buffer: buffer.handle,
            offset: 0,
            size: bytes.len() as u64,
            stage: vk::PipelineStageFlags2::NONE,
            access: vk::AccessFlags2::NONE,
        }
    };
    VolumeInput {
        dimensions: volume.dimensions,
        voxel_size: volume.voxel_size,
        origin: volume.origin,
        density: filled(density, bytemuck::cast_slice(&volume.density)),
        velocity: velocity.and_then(|buffer| {
            let values = volume.velocity.as_ref()?;
            Some(filled(buffer, bytemuck::cast_slice(values)))
        }),
    }
}

const COPIED: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::ALL_TRANSFER,
    access: vk::AccessFlags2::TRANSFER_READ,
    layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
};

fn target_image(image: &Image, extent: [u32; 2]) -> HostImage {
    // The background covers what the frame before left, whose copy the wait has ended.
    let state_in = ImageState::default();
    HostImage { image: image.handle, view: image.view, format: TARGET_FORMAT, extent, state_in, state_out: COPIED }
}

fn backdrop_image(image: &Image, extent: [u32; 2]) -> HostImage {
    HostImage {
        image: image.handle,
        view: image.view,
        format: TARGET_FORMAT,
        extent,
        state_in: COPIED,
        state_out: COPIED,
    }
}

fn whole_image([width, height]: [u32; 2]) -> [vk::BufferImageCopy; 1] {
    let layers = vk::ImageSubresourceLayers {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        mip_level: 0,
        base_array_layer: 0,
        layer_count: 1,
    };
    let extent = vk::Extent3D { width, height, depth: 1 };
    [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)]
}

unsafe fn upload_image(host: &Host, commands: vk::CommandBuffer, from: vk::Buffer, to: vk::Image, size: [u32; 2]) {
    let range = vk::ImageSubresourceRange {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        base_mip_level: 0,
        level_count: 1,
        base_array_layer: 0,
        layer_count: 1,
    };
    let change = |from: ImageState, state: ImageState| {
        vk::ImageMemoryBarrier2::default()
            .src_stage_mask(from.stage)
            .src_access_mask(from.access)
            .dst_stage_mask(state.stage)
            .dst_access_mask(state.access)
            .old_layout(from.layout)
            .new_layout(state.layout)
            .image(to)
            .subresource_range(range)
    };
    let written = ImageState {
        stage: vk::PipelineStageFlags2::ALL_TRANSFER,
        access: vk::AccessFlags2::TRANSFER_WRITE,
        layout: vk::ImageLayout::TRANSFER_DST_OPTIMAL,
    };
    let (before, after) = ([change(ImageState::default(), written)], [change(written, COPIED)]);
    // SAFETY: the caller's.
    unsafe {
        let first = vk::DependencyInfo::default().image_memory_barriers(&before);
        host.device.cmd_pipeline_barrier2(commands, &first);
        host.device.cmd_copy_buffer_to_image(commands, from, to, written.layout, &whole_image(size));
        let second = vk::DependencyInfo::default().image_memory_barriers(&after);
        host.device.cmd_pipeline_barrier2(commands, &second);
    }
}

unsafe fn read_image(host: &Host, commands: vk::CommandBuffer, from: vk::Image, to: vk::Buffer, size: [u32; 2]) {
    // SAFETY: the caller's; the effect left the image in this layout.
    unsafe {
        host.device.cmd_copy_image_to_buffer(commands, from, COPIED.layout, to, &whole_image(size));
    }
    let barriers = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
        .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::HOST)
        .dst_access_mask(vk::AccessFlags2::HOST_READ)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barriers);
    // SAFETY: the caller's.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &dependency) };
}

unsafe fn visible_to_copy(host: &Host, commands: vk::CommandBuffer) {
    let barriers = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
        .dst_access_mask(vk::AccessFlags2::TRANSFER_READ)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barriers);
    // SAFETY: the caller's.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &dependency) };
}
