//! Smoke in a small host: targets with states of its own, two frames in flight, its own queries. The README shows the part
//! between the marks. What is not shown (a device, buffers, submissions) every renderer has.
//!
//! `cargo run --example embed` writes embed.png.

use ash::vk;
use celfx::error::Result;
use celfx::host::{HostBuffer, HostImage, ImageState, TemporalImages};
use celfx::low_level::gpu::buffer::{Buffer, BufferDesc, READ_BACK, UPLOADED};
use celfx::low_level::gpu::headless::{Commands, Headless, Options, Submission};
use celfx::low_level::gpu::image::{Image, ImageDesc};
use celfx::low_level::gpu::scratch::Lifetime;
use celfx::profile::{Timing, queries};
use celfx::simulate::smoke::Builtin;
use celfx::smoke::{Background, Desc, Frame, Sequence, Settings, Smoke, VolumeInput};
use celfx::view::{Camera, Light};

pub const SIZE: [u32; 2] = [160, 120];
pub const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
pub const SKY: [f32; 4] = [0.2, 0.5, 0.9, 1.0];
/// How the host's own drawing leaves the target, and how it wants it back.
const DRAWN: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::ALL_TRANSFER,
    access: vk::AccessFlags2::TRANSFER_WRITE,
    layout: vk::ImageLayout::TRANSFER_DST_OPTIMAL,
};
const SHOWN: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::ALL_TRANSFER,
    access: vk::AccessFlags2::TRANSFER_READ,
    layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
};

/// What the host keeps for each frame in flight.
pub struct Slot {
    pub target: Image,
    pub density: Buffer,
    pub picture: Buffer,
    pub queries: vk::QueryPool,
    pub most_queries: u32,
    pub written: u32,
    pub submission: Option<Submission>,
    pub pictures: Vec<Vec<[u8; 4]>>,
    pub ticks: Vec<Vec<u64>>,
}

impl Slot {
    pub fn new(device: &mut Headless) -> Result<Slot> {
        let voxels = Builtin::Plume.volume(0, 24.0).density.len() as u64;
        let pixels = u64::from(SIZE[0]) * u64::from(SIZE[1]);
        let buffer =
            |name, size, usage, properties| BufferDesc { name, size, usage, properties, lifetime: Lifetime::Kept };
        let (from, to) = (vk::BufferUsageFlags::TRANSFER_SRC, vk::BufferUsageFlags::TRANSFER_DST);
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let (extent, format, lifetime) = (SIZE, FORMAT, Lifetime::Kept);
        let target = ImageDesc { name: "target", extent, layers: 1, array_view: false, format, usage, lifetime };
        let (host, allocator) = device.parts();
        // SAFETY: the handles are the device's own.
        unsafe {
            Ok(Slot {
                target: Image::new(&host, allocator, &target)?,
                density: Buffer::new(&host, allocator, &buffer("density", 4 * voxels, from, UPLOADED))?,
                picture: Buffer::new(&host, allocator, &buffer("picture", 4 * pixels, to, READ_BACK))?,
                queries: vk::QueryPool::null(),
                most_queries: 0,
                written: 0,
                submission: None,
                pictures: Vec::new(),
                ticks: Vec::new(),
            })
        }
    }

    /// Room for so many timestamps.
    fn make_queries(&mut self, device: &Headless, count: u32) {
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
        self.most_queries = count;
        // SAFETY: valid handles of this host's own.
        self.queries = unsafe { device.host().device.create_query_pool(&info, None) }.expect("queries");
    }

    /// Waits for the frame that was here, and keeps what it made.
    pub fn wait(&mut self, device: &mut Headless) -> Result<()> {
        let Some(submission) = self.submission.take() else { return Ok(()) };
        device.wait(submission)?;
        let bytes = self.picture.mapped().expect("mapped memory");
        self.pictures.push(bytes.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect());
        let mut ticks = vec![0_u64; self.written as usize];
        // SAFETY: the frame has ended, and wrote so many queries.
        let got = unsafe {
            let flags = vk::QueryResultFlags::TYPE_64;
            device.host().device.get_query_pool_results(self.queries, 0, &mut ticks, flags)
        };
        got.expect("ticks");
        self.ticks.push(ticks);
        Ok(())
    }

    /// Uploads the volume of frame `n`.
    fn volume(&mut self, n: u32) -> VolumeInput {
        let volume = Builtin::Plume.volume(24 + n, 24.0);
        let bytes: &[u8] = bytemuck::cast_slice(&volume.density);
        self.density.mapped_mut().expect("mapped memory").copy_from_slice(bytes);
        let density = HostBuffer {
            buffer: self.density.handle,
            offset: 0,
            size: self.density.size,
            stage: vk::PipelineStageFlags2::HOST,
            access: vk::AccessFlags2::HOST_WRITE,
        };
        let (dimensions, voxel_size, origin) = (volume.dimensions, volume.voxel_size, volume.origin);
        VolumeInput { dimensions, voxel_size, origin, density, velocity: None }
    }

    fn barrier(&self, device: &Headless, commands: &Commands, from: ImageState, to: ImageState) {
        let range = vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            base_mip_level: 0,
            level_count: 1,
            base_array_layer: 0,
            layer_count: 1,
        };
        let barriers = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(from.stage)
            .src_access_mask(from.access)
            .dst_stage_mask(to.stage)
            .dst_access_mask(to.access)
            .old_layout(from.layout)
            .new_layout(to.layout)
            .image(self.target.handle)
            .subresource_range(range)];
        let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: valid handles of this host's own.
        unsafe { device.host().device.cmd_pipeline_barrier2(commands.raw(), &dependency) };
    }

    /// The host's own drawing.
    fn draw_sky(&self, device: &Headless, commands: &Commands) {
        self.barrier(device, commands, ImageState { layout: vk::ImageLayout::UNDEFINED, ..SHOWN }, DRAWN);
        let colour = vk::ClearColorValue { float32: SKY };
        let range = [vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            base_mip_level: 0,
            level_count: 1,
            base_array_layer: 0,
            layer_count: 1,
        }];
        // SAFETY: valid handles of this host's own, in the layout of the barrier.
        unsafe {
            let host = device.host();
            host.device.cmd_clear_color_image(commands.raw(), self.target.handle, DRAWN.layout, &colour, &range);
            host.device.cmd_reset_query_pool(commands.raw(), self.queries, 0, self.most_queries);
        }
    }

    /// What the host does with the picture.
    fn show(&self, device: &Headless, commands: &Commands) {
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let extent = vk::Extent3D { width: SIZE[0], height: SIZE[1], depth: 1 };
        let regions = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)];
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
            .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)];
        let dependency = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: valid handles of this host's own, in the layout that it asked for.
        unsafe {
            let device = device.host().device.clone();
            let (commands, picture) = (commands.raw(), self.picture.handle);
            device.cmd_copy_image_to_buffer(commands, self.target.handle, SHOWN.layout, picture, &regions);
            device.cmd_pipeline_barrier2(commands, &dependency);
        }
    }

    pub fn destroy(&mut self, device: &mut Headless) {
        let (host, allocator) = device.parts();
        // SAFETY: every frame has been waited for.
        unsafe {
            self.target.destroy(&host, allocator);
            self.density.destroy(&host, allocator);
            self.picture.destroy(&host, allocator);
            host.device.destroy_query_pool(self.queries, None);
        }
    }
}

pub fn render(device: &mut Headless, slots: &mut [Slot; 2], frames: u32) -> Result<Smoke> {
    // README begin
    // Once: the effect, for pictures of one size and volumes up to one size.
    let settings = Settings { particles: 1000, ..Settings::default() };
    let desc = Desc { target_format: FORMAT, seed: 1, ..Desc::new(SIZE, [48, 72, 48], settings) };
    let (host, kernels, allocator) = device.making();
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, desc)? };
    let most = queries(smoke.most_steps()); // timestamps that a frame can take
    slots.iter_mut().for_each(|slot| slot.make_queries(device, most));

    for n in 0..frames {
        let slot = &mut slots[n as usize % 2]; // two frames in flight
        slot.wait(device)?;
        let commands = device.begin()?;
        slot.draw_sky(device, &commands); // the host's own drawing

        let frame = Frame {
            sequence: if n == 0 { Sequence::Restart } else { Sequence::Advance },
            dt: 1.0 / 24.0,
            view: Camera::default().view(SIZE),
            light: Light::default(),
            fire: None,
            volume: Some(slot.volume(n)),
            // DRAWN and SHOWN: stage, access and layout that the host leaves the target in, and wants it back in.
            target: Some(HostImage::new(slot.target.handle, slot.target.view, FORMAT, SIZE, DRAWN, SHOWN)),
            background: Background::Keep, // smoke goes over what the host has drawn
            depth: None,
            edges: None,
            temporal: TemporalImages::default(),
        };
        let mut timing = Timing::Queries { pool: slot.queries, first: 0, count: most };
        unsafe { smoke.record(&device.host(), commands.raw(), &frame, &mut timing)? };

        slot.written = queries(smoke.plan().steps.len() as u32);
        slot.show(device, &commands);
        slot.submission = Some(device.start(commands, "frame")?);
    }
    // README end
    Ok(smoke)
}

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let mut device = Headless::new(&Options::default())?;
    let mut slots = [Slot::new(&mut device)?, Slot::new(&mut device)?];
    let mut smoke = render(&mut device, &mut slots, 24)?;
    for slot in &mut slots {
        slot.wait(&mut device)?;
    }
    if let Some(picture) = slots[1].pictures.last() {
        image::save_buffer("embed.png", picture.as_flattened(), SIZE[0], SIZE[1], image::ExtendedColorType::Rgba8)?;
        println!("frame 24 is in embed.png");
    }
    slots.iter_mut().for_each(|slot| slot.destroy(&mut device));
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { smoke.destroy(&host, allocator) };
    Ok(())
}
