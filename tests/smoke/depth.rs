//! A host's depth: it occludes the smoke, and the smoke writes its own.

use ash::vk;
use celfx::gpu::buffer::{Buffer, BufferDesc};
use celfx::gpu::image::{Image, ImageDesc};
use celfx::gpu::profiler::Timing;
use celfx::gpu::transfer::{CLEARED, record_depth};
use celfx::host::{Host, HostImage};
use celfx::smoke::{DepthFormat, Desc, Frame, HostDepth, Sequence, Smoke, layout};
use gpu_allocator::MemoryLocation;

use crate::common::device;
use crate::host::{COPIED, SIZE, Slot, effect, read};

const FORMAT: vk::Format = vk::Format::D32_SFLOAT;
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;

/// Copies the host's depth, and behind it the smoke's own view depth.
unsafe fn read_depths(host: &Host, commands: vk::CommandBuffer, image: vk::Image, smoke: &Smoke, to: vk::Buffer) {
    let aspect_mask = vk::ImageAspectFlags::DEPTH;
    let layers = vk::ImageSubresourceLayers { aspect_mask, mip_level: 0, base_array_layer: 0, layer_count: 1 };
    let extent = vk::Extent3D { width: SIZE[0], height: SIZE[1], depth: 1 };
    let image_regions = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)];
    let (own, src_offset, _) = smoke.buffer(layout::DEPTH);
    let size = 4 * PIXELS as u64;
    let regions = [vk::BufferCopy { src_offset, dst_offset: size, size }];
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
        .dst_access_mask(vk::AccessFlags2::TRANSFER_READ | vk::AccessFlags2::TRANSFER_WRITE)];
    // SAFETY: the caller's; the effect left the image in this layout.
    unsafe {
        let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
        host.device.cmd_pipeline_barrier2(commands, &dependency);
        host.device.cmd_copy_image_to_buffer(commands, image, COPIED.layout, to, &image_regions);
        host.device.cmd_copy_buffer(commands, own, to, &regions);
    }
}

#[test]
fn a_hosts_depth_occludes_the_smoke_and_takes_its_depth() {
    for (reversed, far) in [(false, 50.0), (true, 50.0), (true, f32::INFINITY)] {
        let Some(mut device) = device() else { return };
        let (host, allocator) = device.parts();
        let desc = Desc { depth: Some(DepthFormat { format: FORMAT, reversed }), ..effect() };
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let image = ImageDesc { name: "host depth", extent: SIZE, layers: 1, array_view: false, format: FORMAT, usage };
        let depths = BufferDesc {
            name: "depths",
            size: 8 * PIXELS as u64,
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            location: MemoryLocation::GpuToCpu,
        };
        // SAFETY: the handles are the device's own.
        let (mut smoke, mut image, mut depths) = unsafe {
            let smoke = Smoke::new(&host, allocator, desc).expect("an effect");
            let image = Image::new(&host, allocator, &image).expect("an image");
            (smoke, image, Buffer::new(&host, allocator, &depths).expect("a buffer"))
        };
        let mut slot = Slot::new(&mut device, SIZE);
        let terms = HostDepth::perspective(0.1, far, reversed);
        let stored = |z: f32| terms[0] + terms[1] / z;
        let mut behind = |wall: f32, sequence| {
            let target = HostImage {
                image: image.handle,
                view: image.view,
                format: FORMAT,
                extent: SIZE,
                state_in: CLEARED,
                state_out: COPIED,
            };
            let frame = Frame { sequence, depth: Some(HostDepth { image: target, terms }), ..slot.frame(0, SIZE) };
            let rendered = device.one_time("frame", |host, commands| {
                // SAFETY: everything is the test's own, and the frame is waited for.
                unsafe {
                    record_depth(host, commands, image.handle, stored(wall));
                    smoke.record(host, commands, &frame, &mut Timing::None)?;
                    read(host, commands, &slot, SIZE);
                    read_depths(host, commands, image.handle, &smoke, depths.handle);
                }
                Ok(())
            });
            rendered.expect("a frame");
            let alpha: Vec<f32> =
                slot.pixels().chunks_exact(16).map(|p| bytemuck::pod_read_unaligned(&p[12..])).collect();
            let both: Vec<f32> =
                depths.mapped().expect("mapped memory").chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
            (alpha, both[..PIXELS].to_vec(), both[PIXELS..].to_vec())
        };
        let (alpha, _, own) = behind(40.0, Sequence::Restart);
        let mut seen: Vec<f32> = own.iter().copied().filter(|z| z.is_finite()).collect();
        assert!(seen.len() > 300, "{} pixels of smoke", seen.len());
        assert!((0..PIXELS).all(|i| (alpha[i] == 1.0) == own[i].is_finite()), "nothing is in front");
        seen.sort_by(f32::total_cmp);
        let wall = seen[seen.len() / 2];
        let (alpha, drawn, own) = behind(wall, Sequence::Hold);
        let mut counts = [0; 2];
        for i in 0..PIXELS {
            // Two roundings of numbers below 1 decide: depths that differ by less may go either way.
            let (smoke, wall) = (stored(own[i].min(1e30)), stored(wall));
            if (smoke - wall).abs() < 4.0 * f32::EPSILON {
                continue;
            }
            let in_front = own[i].is_finite() && (smoke > wall) == reversed;
            counts[usize::from(in_front)] += 1;
            assert_eq!(alpha[i], if in_front { 1.0 } else { 0.0 }, "pixel {i}");
            let expected = if in_front { smoke } else { wall };
            assert!((drawn[i] - expected).abs() <= 2.0 * f32::EPSILON, "pixel {i}: {} for {expected}", drawn[i]);
        }
        assert!(counts.iter().all(|n| *n > 100), "{counts:?}");
        slot.destroy(&mut device);
        let (host, allocator) = device.parts();
        // SAFETY: every frame has been waited for.
        unsafe {
            smoke.destroy(&host, allocator);
            image.destroy(&host, allocator);
            depths.destroy(&host, allocator);
        }
    }
}
