//! A toy host: its own device, targets with states of its own, two frames in flight, its own queries. The README shows
//! the part between the marks.
#![cfg(feature = "cli")]

mod common;

use ash::vk;
use celfx::error::Result;
use celfx::host::{HostBuffer, HostImage, ImageState};
use celfx::low_level::gpu::buffer::{Buffer, BufferDesc, READ_BACK, UPLOADED};
use celfx::low_level::gpu::headless::{Commands, Headless, Submission};
use celfx::low_level::gpu::image::{Image, ImageDesc};
use celfx::profile::Clock;
use celfx::profile::{Timing, queries};
use celfx::simulate::smoke::Builtin;
use celfx::smoke::{Background, Desc, Frame, Sequence, Settings, Smoke, VolumeInput};
use celfx::view::{Camera, Light};

const SIZE: [u32; 2] = [160, 120];
const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
const MOST_STEPS: u32 = 400;
const SKY: [f32; 4] = [0.2, 0.5, 0.9, 1.0];
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
struct Slot {
    target: Image,
    density: Buffer,
    picture: Buffer,
    queries: vk::QueryPool,
    written: u32,
    submission: Option<Submission>,
    pictures: Vec<Vec<[u8; 4]>>,
    ticks: Vec<Vec<u64>>,
}

impl Slot {
    fn new(device: &mut Headless) -> Result<Slot> {
        let voxels = Builtin::Plume.volume(0, 24.0).density.len() as u64;
        let pixels = u64::from(SIZE[0]) * u64::from(SIZE[1]);
        let buffer = |name, size, usage, properties| BufferDesc { name, size, usage, properties };
        let (from, to) = (vk::BufferUsageFlags::TRANSFER_SRC, vk::BufferUsageFlags::TRANSFER_DST);
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let target = ImageDesc { name: "target", extent: SIZE, layers: 1, array_view: false, format: FORMAT, usage };
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP);
        let info = info.query_count(queries(MOST_STEPS));
        let (host, allocator) = device.parts();
        // SAFETY: the handles are the device's own.
        unsafe {
            Ok(Slot {
                target: Image::new(&host, allocator, &target)?,
                density: Buffer::new(&host, allocator, &buffer("density", 4 * voxels, from, UPLOADED))?,
                picture: Buffer::new(&host, allocator, &buffer("picture", 4 * pixels, to, READ_BACK))?,
                queries: host.device.create_query_pool(&info, None).expect("queries"),
                written: 0,
                submission: None,
                pictures: Vec::new(),
                ticks: Vec::new(),
            })
        }
    }

    /// Waits for the frame that was here, and keeps what it made.
    fn wait(&mut self, device: &mut Headless) -> Result<()> {
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
            host.device.cmd_reset_query_pool(commands.raw(), self.queries, 0, queries(MOST_STEPS));
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

    fn destroy(&mut self, device: &mut Headless) {
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

fn render(device: &mut Headless, slots: &mut [Slot; 2], frames: u32) -> Result<Smoke> {
    // README begin
    // Once: the effect, for pictures of one size and volumes up to one size.
    let desc = Desc {
        size: SIZE,
        target_format: FORMAT,
        dimensions: [48, 72, 48],
        velocity: false,
        point_light: false,
        seed: 1,
        settings: Settings { particles: 1000, ..Settings::default() },
        layers: false,
        depth: None,
        edges: false,
    };
    let (host, kernels, allocator) = device.making();
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, desc)? };

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
            volume: Some(slot.volume(n)),
            // DRAWN and SHOWN: stage, access and layout that the host leaves the target in, and wants it back in.
            target: Some(HostImage::new(slot.target.handle, slot.target.view, FORMAT, SIZE, DRAWN, SHOWN)),
            background: Background::Keep, // smoke goes over what the host has drawn
            depth: None,
            edges: None,
        };
        let mut timing = Timing::Queries { pool: slot.queries, first: 0, count: queries(MOST_STEPS) };
        unsafe { smoke.record(&device.host(), commands.raw(), &frame, &mut timing)? };

        slot.written = queries(smoke.plan().steps.len() as u32);
        slot.show(device, &commands);
        slot.submission = Some(device.start(commands, "frame")?);
    }
    // README end
    Ok(smoke)
}

/// Linear light as an sRGB byte.
fn srgb(v: f32) -> u8 {
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

#[test]
fn smoke_in_a_host_of_its_own() {
    let Some(mut device) = common::device() else { return };
    let mut slots = [Slot::new(&mut device).expect("a slot"), Slot::new(&mut device).expect("a slot")];
    let mut smoke = render(&mut device, &mut slots, 7).expect("frames");
    for slot in &mut slots {
        slot.wait(&mut device).expect("the last frames end");
    }
    assert_eq!((slots[0].pictures.len(), slots[1].pictures.len()), (4, 3));
    assert!(smoke.plan().steps.capacity() as u32 <= MOST_STEPS);
    // 0.2, 0.5 and 0.9 as sRGB.
    let sky = [124, 188, 243, 255];
    for picture in slots.iter().flat_map(|slot| &slot.pictures) {
        let over = picture.iter().filter(|c| **c != sky).count();
        assert!(over > 800 && over < picture.len() / 2, "{over} pixels of smoke");
        // Ink, and the darker tones of the default ones, as sRGB; few smoothed pixels reach the brightest.
        assert!(picture.contains(&[0, 0, 0, 255]));
        for tone in Settings::default().tones.into_iter().take(2) {
            let [r, g, b] = tone.colour.map(srgb);
            let near = |c: &&[u8; 4]| c[0].abs_diff(r) <= 1 && c[1].abs_diff(g) <= 1 && c[2].abs_diff(b) <= 1;
            assert!(picture.iter().find(near).is_some(), "no {tone:?}");
        }
    }
    let properties = {
        let host = device.host();
        // SAFETY: valid handles.
        unsafe { host.instance.get_physical_device_properties(host.physical_device) }
    };
    if let Some(mut clock) = Clock::new(64, properties.limits.timestamp_period) {
        for ticks in slots.iter().flat_map(|slot| &slot.ticks) {
            assert!(!ticks.is_empty() && ticks.len() % 2 == 0);
            let times: Vec<u64> = ticks.iter().map(|tick| clock.nanoseconds(*tick)).collect();
            assert!(times.chunks(2).all(|step| step[0] <= step[1]), "a step ends after it begins: {times:?}");
        }
    }
    slots.iter_mut().for_each(|slot| slot.destroy(&mut device));
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { smoke.destroy(&host, allocator) };
}

/// The README shows the part between the marks word for word.
#[test]
fn the_readme_shows_this_host() {
    let source = include_str!("embed.rs");
    let (_, rest) = source.split_once("    // README begin\n").expect("the first mark");
    let (shown, _) = rest.split_once("    // README end").expect("the second mark");
    let lines: Vec<&str> = shown.lines().map(|line| line.strip_prefix("    ").unwrap_or(line)).collect();
    assert!(include_str!("../README.md").contains(&lines.join("\n")), "README.md shows an older tests/embed.rs");
}
